"""The gridworld's oracle: it knows all shortest paths to the treasure, ties included."""

from collections import Counter
from collections.abc import Sequence, Set
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from teachers.atoms import FN, FP, Claim, FeedbackType, Moment
from teachers.oracle import Oracle
from teachers.oracles.gridworld.claims import (
    Answer,
    Avoid,
    Found,
    Go,
    Goal,
    InRoom,
    Map,
    Moves,
    Nearer,
    NextTo,
    NoNearer,
    NotInRoom,
    NoTreasuresIn,
    NotTowards,
    Route,
    Treasure,
    TreasuresIn,
    TriedInVain,
    TriedWell,
    Within,
    walk,
)
from worlds.gridworld import (
    DIRECTIONS,
    NO_DOOR,
    SIDES,
    TREASURE,
    Direction,
    Gridworld,
    Layout,
    Truth,
    distances_from,
    kind_of,
    look_around,
)

_GO = tuple(Go(action=direction) for direction in DIRECTIONS)
_AVOID = tuple(Avoid(action=direction) for direction in DIRECTIONS)
_BASICS = (Goal(), Moves(), Answer(names=tuple(map(str, DIRECTIONS))))
_TRIES = 3
_NEAR = 3
"""Clues about the distance to the treasure state multiples of this."""
_SOME = 3
"""Number of types of rooms, among which is the one of a town's treasures, that a vague rule names."""


@lru_cache(maxsize=4096)
def _verdict(cls: type[Found | Nearer | NoNearer], action: Direction, room: str) -> Claim:
    """A verdict on a move; the same ones recur in each house."""
    return cls(action=action, room=room)


class _Room(NamedTuple):
    """The claims about a room."""

    steps: list[int]
    """Per direction, the moves to the treasure left after it."""
    importance: float
    good: tuple[Direction, ...]
    warnings: tuple[Avoid, ...]


WARNED = tuple(sides.astray or sides.walls for sides in SIDES)
"""Per compass of a room, the directions to warn of, in order: doors that lead astray, or else walls."""
_WARNINGS = tuple(tuple(_AVOID[direction] for direction in warned) for warned in WARNED)


class _Rooms(dict[int, _Room]):
    """The claims about each room, computed at their first use."""

    def __init__(self, doors: Sequence[Sequence[int]], distance: Sequence[int]) -> None:
        self._doors, self._distance = doors, distance

    def __missing__(self, room: int) -> _Room:
        steps, compass = look_around(room, self._doors, self._distance)
        stake = float(max(steps) - min(steps))
        found = self[room] = _Room(steps, stake, SIDES[compass].nearer, _WARNINGS[compass])
        return found


def _map_of(layout: Layout) -> Map:
    """The plan of a house."""
    doors = tuple(tuple("" if behind == NO_DOOR else layout.names[behind] for behind in row) for row in layout.doors)
    return Map(rooms=layout.names, doors=doors, objects=layout.objects)


class GridworldOracle(Oracle[Truth, Gridworld]):
    """Judges moves by their distance to the treasure. A value is the negated number of moves still needed."""

    max_importance = 2.0

    def start(self, truth: Truth) -> None:
        """Find all distances to the treasure, once an episode."""
        doors = truth.layout.doors
        self._rooms = _Rooms(doors, distances_from(truth.layout.treasure, doors))

    def texts_at_hand(self, claim: type[Claim], field: str, moment: Moment[Truth]) -> Sequence[str]:
        """The rooms that a student sees, names of those it was in and can enter, or the types of all rooms."""
        if claim in (InRoom, NotInRoom, TreasuresIn, NoTreasuresIn):
            return tuple(dict.fromkeys(map(kind_of, moment.after.layout.names)))
        here = {truth.room: truth.layout for truth in (moment.before, moment.after) if truth is not None}
        rooms = [each for room, layout in here.items() for each in (room, *layout.doors[room]) if each != NO_DOOR]
        return tuple(dict.fromkeys(moment.after.layout.names[room] for room in rooms))

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        name = self.lab.things[-1]
        basics = _BASICS if name == TREASURE else (_BASICS[0], Treasure(name=name), *_BASICS[1:])
        return (*basics, _map_of(truth.layout)) if self.lab.options["map"] else basics

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A short random walk from the start, move by move; each move is judged once."""
        claims: dict[Claim, None] = {}
        for _ in range(_TRIES):
            if truth.found:
                break
            action = DIRECTIONS[rng.integers(len(DIRECTIONS))]
            verdict = TriedWell if action in self._rooms[truth.room].good else TriedInVain
            claims[verdict(action=action, room=truth.layout.names[truth.room])] = None
            truth = walk(self.lab, truth, action)
        return tuple(claims)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        actions = self.plan(truth, len(truth.layout.doors))
        treasure = truth.layout.names[truth.layout.treasure]
        return (Route(actions=actions, room=treasure),)

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        assert moment.before is not None  # noqa: S101  # hindsight is about an executed action
        room, found, layout = moment.before
        if found:
            return
        action, after = moment.action, moment.after
        if after.found:
            verdict = _verdict(Found, action, layout.names[after.room])
        else:
            good = action in self._rooms[room].good
            verdict = _verdict(Nearer if good else NoNearer, action, layout.names[room])
        if verdict.kind in kinds:
            claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        room, found, _ = moment.after
        if found:
            return
        _, _, good, warnings = self._rooms[room]
        if FP in kinds:
            claims.append(_GO[good[0]])
        if FN in kinds and warnings:
            claims.append(warnings[moment.turn % len(warnings)])

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """Its distance; a kind of room and a side without it; its kind of room; a room next to it.

        Rules of a town come between these.
        """
        room, found, layout = truth
        if found:
            return ()
        kinds = [kind_of(name) for name in layout.names]
        own = kinds[layout.treasure]
        others = Counter(sorted(kind for kind in kinds if kind != own)).most_common(1)
        path = self.plan(truth, len(kinds))
        aside = [d for d in DIRECTIONS if path.count(d) <= path.count(DIRECTIONS[3 - d])]
        open_ = [d for d in aside if layout.doors[room][d] != NO_DOOR]
        beside = [behind for behind in layout.doors[layout.treasure] if behind != NO_DOOR]
        few = min(beside, key=lambda behind: sum(door != NO_DOOR for door in layout.doors[behind]))
        rules = self._rules(layout.law)
        return (
            *rules[:1],
            Within(moves=-(-len(path) // _NEAR) * _NEAR),
            *(NotInRoom(room=kind) for kind, _ in others),
            NotTowards(side=(open_ or aside)[0]),
            *rules[1:],
            *(InRoom(room=own) for _ in others),  # said of houses with other kinds of rooms
            NextTo(room=layout.names[few]),
        )

    def _rules(self, law: str) -> tuple[Claim, ...]:
        """Rules of a town: a type of room without treasures, several types that may have them, and the one that has."""
        types = self.lab.options["room_types"]
        if not law or len(types) == 1:
            return ()
        i = types.index(law)
        following = (*types[i:], *types[:i])
        some = (law, *following[1:_SOME]) if len(types) > _SOME else ()
        return NoTreasuresIn(rooms=following[-1:]), *(TreasuresIn(rooms=each) for each in (some, (law,)) if each)

    def values(self, truth: Truth) -> tuple[float, ...]:
        """Per direction, the negated number of moves left after it; all 0 once the treasure is found."""
        return (0.0, 0.0, 0.0, 0.0) if truth.found else tuple([-float(each) for each in self._rooms[truth.room].steps])

    def idle(self, truth: Truth) -> float:
        """One move; 0 once the treasure is found."""
        return float(not truth.found)

    def importance(self, truth: Truth) -> float:
        """Difference in moves between the best and the worst direction, 0 to 2."""
        return 0.0 if truth.found else self._rooms[truth.room].importance

    def plan(self, truth: Truth, n: int) -> tuple[Direction, ...]:
        """A shortest path, or its beginning."""
        room, found, layout = truth
        path: list[Direction] = []
        while not found and len(path) < n:
            direction = self._rooms[room].good[0]
            path.append(direction)
            room = layout.doors[room][direction]
            found = room == layout.treasure
        return tuple(path)
