"""The best times to advise, found by a search through all of them, for students who do nothing by chance."""

import math
from collections.abc import Callable
from typing import NamedTuple


class Rooms(NamedTuple):
    """What a lifetime is lived in: rooms, and moves that always lead the same way."""

    behind: list[list[int]]
    """Per room and direction where one is afterwards."""
    distance: list[int]
    """Per room the moves to the treasure."""
    advice: list[int]
    """Per room the direction that is advised."""
    start: int
    """The room in which every episode begins."""


class Span(NamedTuple):
    """Of a lifetime."""

    episodes: int
    turns: int
    """Of an episode, at most."""
    optimism: float
    """What the student holds all actions to be worth at first."""
    alpha: float = 0.5
    gamma: float = 0.95


class Life:
    """A greedy student of tabular Q-learning: where values are equal it takes one after the other, visit by visit.

    It takes the advised direction for the turn, and learns from what comes of it.
    """

    __slots__ = ("_values", "_visits", "episode", "house", "lost", "moves", "room", "said", "settled", "span", "turn")

    def __init__(self, house: Rooms, span: Span) -> None:
        self.house, self.span = house, span
        self._values = [(span.optimism,) * len(house.behind[0])] * len(house.behind)
        self._visits = [0] * len(house.behind)
        self.room, self.turn, self.episode = house.start, 0, 0
        self.lost = 0
        """Moves that were wasted."""
        self.moves = 0
        """All of them."""
        self.settled = 0
        """The number of the last move that was wasted or advised."""
        self.said = 0
        """Pieces of advice."""

    def copy(self) -> "Life":
        """The same up to now; what becomes of the two is independent."""
        twin = object.__new__(Life)
        twin.house, twin.span = self.house, self.span
        twin._values, twin._visits = self._values[:], self._visits[:]
        twin.room, twin.turn, twin.episode = self.room, self.turn, self.episode
        twin.lost, twin.moves, twin.settled, twin.said = self.lost, self.moves, self.settled, self.said
        return twin

    @property
    def over(self) -> bool:
        """Whether all episodes have been lived."""
        return self.episode == self.span.episodes

    def left(self) -> list[int]:
        """Per direction the moves to the treasure that are left after it."""
        return [self.house.distance[room] for room in self.house.behind[self.room]]

    def meant(self) -> int:
        """What the student does next unless it is advised."""
        values = self._values[self.room]
        best = max(values)
        ties = [side for side, value in enumerate(values) if value == best]
        return ties[self._visits[self.room] % len(ties)]

    def go(self, side: int, *, advised: bool) -> None:
        """A move of the student."""
        house, span, room = self.house, self.span, self.room
        to = house.behind[room][side]
        found = house.distance[to] == 0
        values = list(self._values[room])
        ahead = 1.0 if found else span.gamma * max(self._values[to])
        values[side] += span.alpha * (ahead - values[side])
        self._values[room] = tuple(values)
        self._visits[room] += 1
        wasted = 1 + house.distance[to] - house.distance[room]
        self.lost += wasted
        self.moves += 1
        self.said += advised
        if wasted or advised:
            self.settled = self.moves
        self.room, self.turn = to, self.turn + 1
        if found or self.turn == span.turns:
            self.room, self.turn, self.episode = house.start, 0, self.episode + 1


def lived(life: Life, rule: Callable[[Life], bool], budget: float) -> Life:
    """What becomes of a lifetime if a rule says when to advise."""
    life = life.copy()
    while not life.over:
        speaks = life.said < budget and rule(life)
        life.go(life.house.advice[life.room] if speaks else life.meant(), advised=speaks)
    return life


def least(life: Life, cost: Callable[[Life], float], budget: float, known: float = math.inf) -> float:
    """The least cost of a lifetime that any choice of times to advise comes to.

    Args:
        life: up to now.
        cost: never becomes less as a lifetime goes on.
        budget: pieces of advice in all.
        known: the cost of some choice; what is not below it is not looked at.
    """
    life = life.copy()
    while cost(life) < known:
        if life.over:
            return cost(life)
        meant, advice = life.meant(), life.house.advice[life.room]
        if life.said < budget and meant != advice:
            told = life.copy()
            told.go(advice, advised=True)
            known = least(told, cost, budget, known)
        life.go(meant, advised=False)
    return known
