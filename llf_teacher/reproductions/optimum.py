"""The best times to advise deterministic students, by an exhaustive search."""

import math
from collections.abc import Callable
from typing import NamedTuple


class Rooms(NamedTuple):
    """The world of a lifetime: rooms with deterministic moves."""

    behind: list[list[int]]
    """Per room and direction, the next room."""
    distance: list[int]
    """Per room, the moves to the treasure."""
    advice: list[int]
    """Per room, the advised direction."""
    start: int
    """The first room of every episode."""


class Span(NamedTuple):
    """The parameters of a lifetime."""

    episodes: int
    turns: int
    """Greatest number of an episode."""
    optimism: float
    """The initial value of all actions."""
    alpha: float = 0.5
    gamma: float = 0.95


class Life:
    """A lifetime of a student with greedy tabular Q-learning, which breaks ties in turn, visit by visit.

    It takes the advised direction, and learns from its result.
    """

    __slots__ = ("_values", "_visits", "episode", "house", "lost", "moves", "room", "said", "settled", "span", "turn")

    def __init__(self, house: Rooms, span: Span) -> None:
        self.house, self.span = house, span
        self._values = [(span.optimism,) * len(house.behind[0])] * len(house.behind)
        self._visits = [0] * len(house.behind)
        self.room, self.turn, self.episode = house.start, 0, 0
        self.lost = 0
        """Number of wasted moves."""
        self.moves = 0
        """Number of all moves."""
        self.settled = 0
        """Number of the last move that was wasted or advised."""
        self.said = 0
        """Number of pieces of advice."""

    def copy(self) -> "Life":
        """An independent copy."""
        twin = object.__new__(Life)
        twin.house, twin.span = self.house, self.span
        twin._values, twin._visits = self._values[:], self._visits[:]
        twin.room, twin.turn, twin.episode = self.room, self.turn, self.episode
        twin.lost, twin.moves, twin.settled, twin.said = self.lost, self.moves, self.settled, self.said
        return twin

    @property
    def over(self) -> bool:
        """Whether all episodes have ended."""
        return self.episode == self.span.episodes

    def left(self) -> list[int]:
        """Per direction, the moves that remain to the treasure after it."""
        return [self.house.distance[room] for room in self.house.behind[self.room]]

    def meant(self) -> int:
        """The student's next direction without advice."""
        values = self._values[self.room]
        best = max(values)
        ties = [side for side, value in enumerate(values) if value == best]
        return ties[self._visits[self.room] % len(ties)]

    def go(self, side: int, *, advised: bool) -> None:
        """Move the student."""
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
    """The end of a lifetime in which a rule decides when to advise."""
    life = life.copy()
    while not life.over:
        speaks = life.said < budget and rule(life)
        life.go(life.house.advice[life.room] if speaks else life.meant(), advised=speaks)
    return life


def least(life: Life, cost: Callable[[Life], float], budget: float, known: float = math.inf) -> float:
    """The least cost of a lifetime over all choices of times to advise, by branch and bound.

    Args:
        life: its beginning.
        cost: of a lifetime; never decreases as it goes on.
        budget: pieces of advice in all.
        known: the cost of a known choice; branches that are not below it are cut.
    """
    life = life.copy()
    while cost(life) < known:
        if life.over:
            return cost(life)
        meant, advice = life.meant(), life.house.advice[life.room]
        if life.said < budget and meant != advice:
            branch = life.copy()
            branch.go(advice, advised=True)
            known = least(branch, cost, budget, known)
        life.go(meant, advised=False)
    return known
