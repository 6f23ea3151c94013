"""The gridworld's oracle: shortest paths to the treasure from everywhere, every tie known."""

from collections import deque
from collections.abc import Sequence, Set
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim
from teachers.oracle import Oracle
from worlds.gridworld import DIRECTIONS, NO_DOOR, Direction, Truth, distances_from
from worlds.world import World


@claim
class Goal(Claim):
    """True if entering the room of the treasure, and no other, solves the task."""

    def holds(self, moment: Moment, lab: World) -> bool:
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
class Moves(Claim):
    """True if a move leads through the door on that side, and leaves the student in place where there is none."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try the four directions."""
        truth = moment.after
        return all(
            _step(lab, truth, direction).room == (truth.room if behind == NO_DOOR else behind)
            for direction, behind in zip(DIRECTIONS, truth.layout.doors[truth.room], strict=True)
        )


@claim
class Answer(Claim):
    """True if these four words are the names of the four actions, numbered from 0 in this order."""

    names: tuple[str, str, str, str]
    listing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the words up in the world's vocabulary."""
        return [lab.action_words.get(name) for name in self.names] == list(DIRECTIONS) and all(
            name in self.listing for name in self.names
        )


@claim
class TriedWell(Claim):
    """True if going `action` from the named room leads to a room that is nearer to the treasure."""

    kind = HP
    action: Direction
    room: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Measure both rooms by breadth-first search."""
        return (
            _gain(lab, Truth(moment.after.layout.names.index(self.room), False, moment.after.layout), self.action) > 0
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, room=self.room),)


@claim
class TriedInVain(Claim):
    """True if going `action` from the named room leads to a room that is no nearer to the treasure, or nowhere."""

    kind = HN
    action: Direction
    room: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Measure both rooms by breadth-first search."""
        return (
            _gain(lab, Truth(moment.after.layout.names.index(self.room), False, moment.after.layout), self.action) <= 0
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, room=self.room),)


@claim
class Route(Claim):
    """True if these moves, in order, lead from the start to the treasure and no shorter sequence does."""

    actions: tuple[Direction, ...]
    listing: str
    room: str
    """The room that holds the treasure."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Walk the route."""
        truth = moment.after
        if len(self.actions) != _distance(truth) or self.listing != ", ".join(map(str, self.actions)):
            return False
        lab.restore(truth)
        success = [lab.advance(action)[4]["success"] for action in self.actions]
        return success[-1] and self.room == truth.layout.names[lab.truth.room]


@claim
class Found(Claim):
    """True if this move entered the room of the treasure for the first time."""

    kind = HP
    action: Direction
    room: str
    """Where the move led."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the move again."""
        if moment.before is None or moment.before.found or moment.action != self.action:
            return False
        after = _step(lab, moment.before, self.action)
        return after.found and after.layout.names[after.room] == self.room

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny it."""
        return (NoNearer(action=self.action, room=moment.before.layout.names[moment.before.room]),)


@claim
class Nearer(Claim):
    """True if this move out of the named room ended nearer to the treasure: it began a shortest path."""

    kind = HP
    action: Direction
    room: str
    """Where the move began."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the move again and measure by breadth-first search."""
        return _made(self, moment) and _gain(lab, moment.before, self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (NoNearer(action=self.action, room=self.room),)


@claim
class NoNearer(Claim):
    """True if this move out of the named room did not end nearer to the treasure: it began no shortest path."""

    kind = HN
    action: Direction
    room: str
    """Where the move began."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the move again and measure by breadth-first search."""
        return _made(self, moment) and _gain(lab, moment.before, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Nearer(action=self.action, room=self.room),)


@claim
class Go(Claim):
    """True if `action` begins a shortest path to a treasure not yet found; every tied path counts."""

    kind = FP
    action: Direction

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Recommend another direction."""
        return tuple(Go(action=direction) for direction in DIRECTIONS if direction != self.action)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Three directions, then two; where there are other doors, these lead through them."""
        doors = moment.after.layout.doors[moment.after.room]
        others = sorted((d for d in DIRECTIONS if d != self.action), key=lambda d: doors[d] == NO_DOOR)
        return tuple(_either((self.action, *others[:n])) for n in (2, 1))


@claim
class Either(Claim):
    """True if one of these directions begins a shortest path to a treasure not yet found."""

    kind = FP
    ways: tuple[Direction, ...]
    listing: str
    """The directions in words, such as `north or west`."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the moves and measure by breadth-first search."""
        named = self.listing == _either(self.ways).listing
        return named and not moment.after.found and any(_gain(lab, moment.after, way) > 0 for way in self.ways)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """As many other directions."""
        return tuple(_either(ways) for ways in combinations(DIRECTIONS, len(self.ways)) if ways != self.ways)


@claim
class Avoid(Claim):
    """True if `action` does not begin a shortest path to a treasure not yet found."""

    kind = FN
    action: Direction

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of another direction."""
        return tuple(Avoid(action=direction) for direction in DIRECTIONS if direction != self.action)


def _either(ways: Sequence[Direction]) -> Either:
    *rest, last = ways = tuple(sorted(ways))
    return Either(ways=ways, listing=f"{', '.join(map(str, rest))} or {last}")


def _step(lab: World, truth: Truth, direction: Direction) -> Truth:
    lab.restore(truth)
    lab.advance(direction)
    return lab.truth


def _gain(lab: World, truth: Truth, direction: Direction) -> int:
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


def _made(said: Nearer | NoNearer, moment: Moment) -> bool:
    before = moment.before
    return (
        before is not None
        and not before.found
        and moment.action == said.action
        and before.layout.names[before.room] == said.room
    )


@lru_cache(maxsize=4096)
def _verdict(nearer: bool, action: Direction, room: str) -> Nearer | NoNearer:
    return (Nearer if nearer else NoNearer)(action=action, room=room)


_GO = tuple(Go(action=direction) for direction in DIRECTIONS)
_AVOID = tuple(Avoid(action=direction) for direction in DIRECTIONS)
_BASICS = (
    Goal(),
    Moves(),
    Answer(names=tuple(map(str, DIRECTIONS)), listing=", ".join(f"{d} ({int(d)})" for d in DIRECTIONS)),
)
_TRIES = 3


class _Room(NamedTuple):
    """What can be said of a room."""

    values: tuple[float, ...]
    importance: float
    good: tuple[Direction, ...]
    warnings: tuple[Avoid, ...]


# Per set of directions, as bits, its members, and the warnings of them.
_MEMBERS = tuple(tuple(d for d in DIRECTIONS if bits >> d & 1) for bits in range(16))
_WARNINGS = tuple(tuple(_AVOID[d] for d in members) for members in _MEMBERS)


class GridworldOracle(Oracle):
    """Judges moves by their distance to the treasure. A value is the negated number of moves still needed."""

    max_importance = 2.0

    def start(self, truth: Truth) -> None:
        """Find all distances to the treasure, once an episode."""
        self._doors = truth.layout.doors
        self._distance = distances_from(truth.layout.treasure, self._doors)
        self._rooms: dict[int, _Room] = {}

    def _room(self, room: int) -> _Room:
        """Judge every door of a room, when it is first entered."""
        found = self._rooms.get(room)
        if found is None:
            distance = self._distance
            here, good, astray = distance[room], 0, 0
            values = []
            for side, behind in enumerate(self._doors[room]):
                steps = here if behind == NO_DOOR else distance[behind]
                values.append(-float(steps))
                if steps < here:
                    good |= 1 << side
                elif behind != NO_DOOR:
                    astray |= 1 << side
            # A door that leads astray is the better warning; where there is none, a wall has to do.
            warnings = _WARNINGS[astray or 15 & ~good]
            found = self._rooms[room] = _Room(tuple(values), max(values) - min(values), _MEMBERS[good], warnings)
        return found

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        return _BASICS

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A short random walk from the start, move by move; a move that was tried before is not told twice."""
        told: dict[Claim, None] = {}
        for _ in range(_TRIES):
            if truth.found:
                break
            action = DIRECTIONS[rng.integers(len(DIRECTIONS))]
            verdict = TriedWell if action in self._room(truth.room).good else TriedInVain
            told[verdict(action=action, room=truth.layout.names[truth.room])] = None
            truth = _step(self.lab, truth, action)
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        actions = self.plan(truth, len(truth.layout.doors))
        treasure = truth.layout.names[truth.layout.treasure]
        return (Route(actions=actions, listing=", ".join(map(str, actions)), room=treasure),)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        room, found, layout = moment.before
        if found:
            return
        action = moment.action
        if moment.after.found:
            verdict: Claim = Found(action=action, room=layout.names[moment.after.room])
        else:
            verdict = _verdict(action in self._room(room).good, action, layout.names[room])
        if verdict.kind in kinds:
            claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        room, found, _ = moment.after
        if found:
            return
        _, _, good, warnings = self._room(room)
        if FP in kinds:
            claims.append(_GO[good[0]])
        if FN in kinds and warnings:
            claims.append(warnings[moment.turn % len(warnings)])

    def values(self, truth: Truth) -> tuple[float, ...]:
        """Per direction the negated number of moves that are needed afterwards; all 0 once it is found."""
        return (0.0, 0.0, 0.0, 0.0) if truth.found else self._room(truth.room).values

    def importance(self, truth: Truth) -> float:
        """Moves between the best and the worst direction, 0 to 2."""
        return 0.0 if truth.found else self._room(truth.room).importance

    def plan(self, truth: Truth, n: int) -> tuple[Direction, ...]:
        """A shortest path, or its beginning."""
        room, found, layout = truth
        path = []
        while not found and len(path) < n:
            direction = self._room(room).good[0]
            path.append(direction)
            room = layout.doors[room][direction]
            found = room == layout.treasure
        return tuple(path)
