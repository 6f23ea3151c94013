"""The gridworld's oracle: shortest paths to the treasure from everywhere, every tie known."""

from collections import deque
from collections.abc import Sequence, Set
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, FeedbackType, Moment, PlanClaim, Verdict, claim, opposed
from teachers.oracle import Oracle
from worlds.gridworld import (
    DIRECTIONS,
    NO_DOOR,
    SIDES,
    TREASURE,
    Direction,
    Gridworld,
    Truth,
    distances_from,
    look_around,
)


@claim
class Goal(Claim[Truth, Gridworld]):
    """True if entering the room of the treasure, and no other, solves the task."""

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Walk through every door of the house."""
        layout = moment.after.layout
        for room, row in enumerate(layout.doors):
            for direction, behind in zip(DIRECTIONS, row, strict=True):
                if behind != NO_DOOR:
                    lab.restore(Truth(room, False, layout))
                    if lab.advance(direction)[4]["success"] != (behind == layout.treasure):
                        return False
        return True


@claim
class Treasure(Claim[Truth, Gridworld]):
    """True if the room of the treasure, and no other, has something of this name in it."""

    name: str

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look around in every room."""
        layout = moment.after.layout
        if self.name not in lab.things:
            return False
        seen = []
        for room in range(len(layout.doors)):
            lab.restore(Truth(room, False, layout))
            if lab.observe()["objects"][lab.things.index(self.name)]:
                seen.append(room)
        return seen == [layout.treasure]


@claim
class Moves(Claim[Truth, Gridworld]):
    """True if a move leads through the door on that side, and leaves the student in place where there is none."""

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Try the four directions."""
        truth = moment.after
        return all(
            _step(lab, truth, direction).room == (truth.room if behind == NO_DOOR else behind)
            for direction, behind in zip(DIRECTIONS, truth.layout.doors[truth.room], strict=True)
        )


@claim
class Answer(Claim[Truth, Gridworld]):
    """True if these four words are the names of the four actions, numbered from 0 in this order."""

    names: tuple[str, ...]

    @property
    def listing(self) -> str:
        """The words with their numbers."""
        return ", ".join(f"{name} ({number})" for number, name in enumerate(self.names))

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look the words up in the world's vocabulary."""
        return [lab.action_words.get(name) for name in self.names] == list(DIRECTIONS)


@claim
class _Tried(Verdict[Truth, Gridworld], ActionClaim[Truth, Gridworld]):
    """What became of a move that somebody made before."""

    action: Direction
    room: str

    def applies(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """From every room one can try to go anywhere."""
        return self.room in moment.after.layout.names

    def good(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Measure both rooms by breadth-first search."""
        layout = moment.after.layout
        return _gain(lab, Truth(layout.names.index(self.room), False, layout), self.action) > 0


@claim
class TriedWell(_Tried):
    """True if going `action` from the named room leads to a room that is nearer to the treasure."""

    kind = HP


@claim
class TriedInVain(_Tried):
    """True if going `action` from the named room leads to a room that is no nearer to the treasure, or nowhere."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Route(PlanClaim[Truth, Gridworld]):
    """True if these moves, in order, lead from the start to the treasure and no shorter sequence does."""

    actions: tuple[Direction, ...]
    room: str
    """The room that holds the treasure."""

    @property
    def listing(self) -> str:
        """The moves in words."""
        return self.separator.join(map(str, self.actions))

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Walk the route."""
        truth = moment.after
        if len(self.actions) != _distance(truth):
            return False
        lab.restore(truth)
        success = [lab.advance(action)[4]["success"] for action in self.actions]
        return success[-1] and self.room == truth.layout.names[lab.truth.room]


@claim
class Found(ActionClaim[Truth, Gridworld]):
    """True if this move entered the room of the treasure for the first time."""

    kind = HP
    action: Direction
    room: str
    """Where the move led."""

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move again."""
        if moment.before is None or moment.before.found or moment.action != self.action:
            return False
        after = _step(lab, moment.before, self.action)
        return after.found and after.layout.names[after.room] == self.room

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Deny it."""
        truth = moment.past
        return (NoNearer(action=self.action, room=truth.layout.names[truth.room]),)


@claim
class _Made(Verdict[Truth, Gridworld], ActionClaim[Truth, Gridworld]):
    """What became of the student's move."""

    action: Direction
    room: str
    """Where the move began."""

    def applies(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look the move up; who has found the treasure goes anywhere."""
        before = moment.before
        return (
            before is not None
            and not before.found
            and moment.action == self.action
            and before.layout.names[before.room] == self.room
        )

    def good(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move again and measure by breadth-first search."""
        return _gain(lab, moment.past, self.action) > 0


@claim
class Nearer(_Made):
    """True if this move out of the named room ended nearer to the treasure: it began a shortest path."""

    kind = HP


@claim
class NoNearer(_Made):
    """True if this move out of the named room did not end nearer to the treasure: it began no shortest path."""

    kind = HN


opposed(Nearer, NoNearer)


@claim
class Go(ActionClaim[Truth, Gridworld]):
    """True if `action` begins a shortest path to a treasure not yet found; every tied path counts."""

    kind = FP
    action: Direction

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) > 0

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Recommend another direction."""
        return tuple(Go(action=direction) for direction in DIRECTIONS if direction != self.action)

    def coarser(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Three directions, then two; where there are other doors, these lead through them."""
        doors = moment.after.layout.doors[moment.after.room]
        others = sorted((d for d in DIRECTIONS if d != self.action), key=lambda d: doors[d] == NO_DOOR)
        return tuple(Either(ways=tuple(sorted((self.action, *others[:n])))) for n in (2, 1))


@claim
class Either(Claim[Truth, Gridworld]):
    """True if one of these directions begins a shortest path to a treasure not yet found."""

    kind = FP
    ways: tuple[Direction, ...]

    @property
    def listing(self) -> str:
        """The directions in words, such as `north or west`."""
        *rest, last = self.ways
        return f"{', '.join(map(str, rest))} or {last}"

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the moves and measure by breadth-first search."""
        return not moment.after.found and any(_gain(lab, moment.after, way) > 0 for way in self.ways)

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """As many other directions."""
        return tuple(Either(ways=ways) for ways in combinations(DIRECTIONS, len(self.ways)) if ways != self.ways)


@claim
class Avoid(ActionClaim[Truth, Gridworld]):
    """True if `action` does not begin a shortest path to a treasure not yet found."""

    kind = FN
    action: Direction

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) <= 0

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Warn of another direction."""
        return tuple(Avoid(action=direction) for direction in DIRECTIONS if direction != self.action)


def _step(lab: Gridworld, truth: Truth, direction: Direction) -> Truth:
    lab.restore(truth)
    lab.advance(direction)
    return lab.truth


def _gain(lab: Gridworld, truth: Truth, direction: Direction) -> int:
    return _distance(truth) - _distance(_step(lab, truth, direction))


def _distance(truth: Truth) -> int:
    """Moves to the treasure, by breadth-first search from the student's room."""
    seen, queue = {truth.room: 0}, deque((truth.room,))
    while truth.layout.treasure not in seen:
        room = queue.popleft()
        for behind in truth.layout.doors[room]:
            if behind != NO_DOOR and behind not in seen:
                seen[behind] = seen[room] + 1
                queue.append(behind)
    return seen[truth.layout.treasure]


@lru_cache(maxsize=4096)
def _verdict(nearer: bool, action: Direction, room: str) -> Nearer | NoNearer:
    return (Nearer if nearer else NoNearer)(action=action, room=room)


_GO = tuple(Go(action=direction) for direction in DIRECTIONS)
_AVOID = tuple(Avoid(action=direction) for direction in DIRECTIONS)
_BASICS = (Goal(), Moves(), Answer(names=tuple(map(str, DIRECTIONS))))
_TRIES = 3


class _Room(NamedTuple):
    """What can be said of a room."""

    values: tuple[float, ...]
    importance: float
    good: tuple[Direction, ...]
    warnings: tuple[Avoid, ...]


WARNED = tuple(sides.astray or sides.walls for sides in SIDES)
"""Per compass of a room the directions to warn of, in turns: doors that lead astray, or walls where there are none."""
_WARNINGS = tuple(tuple(_AVOID[direction] for direction in warned) for warned in WARNED)


class _Rooms(dict[int, _Room]):
    """Per room what can be said of it: all of its doors are judged when it is first asked for."""

    def __init__(self, doors: Sequence[Sequence[int]], distance: Sequence[int]) -> None:
        self._doors, self._distance = doors, distance

    def __missing__(self, room: int) -> _Room:
        steps, compass = look_around(room, self._doors, self._distance)
        values = tuple([-float(each) for each in steps])
        found = self[room] = _Room(values, float(max(steps) - min(steps)), SIDES[compass].nearer, _WARNINGS[compass])
        return found


class GridworldOracle(Oracle[Truth, Gridworld]):
    """Judges moves by their distance to the treasure. A value is the negated number of moves still needed."""

    max_importance = 2.0

    def start(self, truth: Truth) -> None:
        """Find all distances to the treasure, once an episode."""
        doors = truth.layout.doors
        self._rooms = _Rooms(doors, distances_from(truth.layout.treasure, doors))

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        name = self.lab.things[-1]
        return _BASICS if name == TREASURE else (_BASICS[0], Treasure(name=name), *_BASICS[1:])

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A short random walk from the start, move by move; a move that was tried before is not told twice."""
        told: dict[Claim, None] = {}
        for _ in range(_TRIES):
            if truth.found:
                break
            action = DIRECTIONS[rng.integers(len(DIRECTIONS))]
            verdict = TriedWell if action in self._rooms[truth.room].good else TriedInVain
            told[verdict(action=action, room=truth.layout.names[truth.room])] = None
            truth = _step(self.lab, truth, action)
        return tuple(told)

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
            verdict: Claim = Found(action=action, room=layout.names[after.room])
        else:
            verdict = _verdict(action in self._rooms[room].good, action, layout.names[room])
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

    def values(self, truth: Truth) -> tuple[float, ...]:
        """Per direction the negated number of moves that are needed afterwards; all 0 once it is found."""
        return (0.0, 0.0, 0.0, 0.0) if truth.found else self._rooms[truth.room].values

    def idle(self, truth: Truth) -> float:
        """A move; none once it is found."""
        return float(not truth.found)

    def importance(self, truth: Truth) -> float:
        """Moves between the best and the worst direction, 0 to 2."""
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
