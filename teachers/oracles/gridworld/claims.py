"""The claims about moves, each checked by walking in the lab and breadth-first search."""

from collections import deque
from collections.abc import Sequence
from itertools import combinations
from typing import Annotated, Any

from typing_extensions import override

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    HintClaim,
    Moment,
    PlanClaim,
    Scope,
    Verdict,
    claim,
    opposed,
    slot,
)
from teachers.rules import TownRule
from teachers.spec import Range
from teachers.words import article, listed
from worlds.gridworld import (
    DIRECTIONS,
    NO_DOOR,
    Direction,
    Gridworld,
    Truth,
    kind_of,
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
class Map(Claim[Truth, Gridworld]):
    """True if these are the rooms of the house, with what is in each beside the treasure, and where its doors lead."""

    rooms: tuple[str, ...]
    doors: tuple[tuple[str, ...], ...]
    """For each room the names of the rooms to the north, east, west and south of it; empty where there is no door."""
    objects: tuple[tuple[str, ...], ...]

    @property
    def listing(self) -> str:
        """The rooms one after the other."""
        return "; ".join(map(_in_words, self.rooms, self.doors, self.objects))

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look around in every room, and go through every door."""
        layout = moment.after.layout
        for room, name in enumerate(layout.names):
            here = Truth(room, False, layout)
            lab.restore(here)
            seen = lab.observe()["objects"][:-1].tolist()
            objects = {thing for thing, lies in zip(lab.things, seen, strict=False) if lies}
            behind = [walk(lab, here, direction).room for direction in DIRECTIONS]
            doors = tuple("" if other == room else layout.names[other] for other in behind)
            if (name, doors, objects) != (self.rooms[room], self.doors[room], set(self.objects[room])):
                return False
        return len(self.rooms) == len(self.doors) == len(self.objects) == len(layout.names)


@claim
class Moves(Claim[Truth, Gridworld]):
    """True if a move leads through the door on that side, and leaves the student in place where there is none."""

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Try the four directions."""
        truth = moment.after
        return all(
            walk(lab, truth, direction).room == (truth.room if behind == NO_DOOR else behind)
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
    """Base of verdicts on a move that the oracle tried."""

    tried = True
    action: Direction
    room: str

    def applies(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Every move can be tried from every room."""
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
        after = walk(lab, moment.before, self.action)
        return after.found and after.layout.names[after.room] == self.room

    def worth(self, moment: Moment[Truth], lab: Gridworld, action: Direction) -> float:
        """Make the move instead and measure by breadth-first search."""
        return -float(_distance(walk(lab, moment.past, action)))

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Deny it."""
        truth = moment.past
        return (NoNearer(action=self.action, room=truth.layout.names[truth.room]),)


@claim
class _Made(Verdict[Truth, Gridworld], ActionClaim[Truth, Gridworld]):
    """Base of verdicts on the student's move."""

    action: Direction
    room: str
    """Where the move began."""

    def applies(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look the move up; no move is judged once the treasure is found."""
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

    def worth(self, moment: Moment[Truth], lab: Gridworld, action: Direction) -> float:
        """Make the move instead and measure by breadth-first search."""
        return -float(_distance(walk(lab, moment.past, action)))


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
    counterparts = Claim.varied("action", DIRECTIONS)

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) > 0

    def coarser(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """Three directions, then two; through other doors if there are any."""
        doors = moment.after.layout.doors[moment.after.room]
        others = sorted((d for d in DIRECTIONS if d != self.action), key=lambda d: doors[d] == NO_DOOR)
        return tuple(Either(ways=tuple(sorted((self.action, *others[:n])))) for n in (2, 1))


@claim
class Either(HintClaim[Truth, Gridworld]):
    """True if one of these directions begins a shortest path to a treasure not yet found."""

    kind = FP
    ways: tuple[Direction, ...]
    counterparts = Claim.varied("ways", lambda claim, _, __: combinations(DIRECTIONS, len(claim.ways)))
    listing = slot(listed, "ways")

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the moves and measure by breadth-first search."""
        return not moment.after.found and any(_gain(lab, moment.after, way) > 0 for way in self.ways)

    @override
    def leaves(self, action: Direction) -> bool:
        return action in self.ways


@claim
class Avoid(ActionClaim[Truth, Gridworld]):
    """True if `action` does not begin a shortest path to a treasure not yet found."""

    kind = FN
    action: Direction
    counterparts = Claim.varied("action", DIRECTIONS)

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Make the move and measure by breadth-first search."""
        return not moment.after.found and _gain(lab, moment.after, self.action) <= 0


@claim
class NotTowards(Claim[Truth, Gridworld]):
    """True if the room of the treasure, not yet found, lies no farther to this side of the house than the student."""

    kind = FN
    side: Direction
    counterparts = Claim.varied("side", DIRECTIONS)

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Walk through the house, and count how far each room is to that side."""
        truth = moment.after
        ahead, seen, left = {self.side: 1, DIRECTIONS[3 - self.side]: -1}, {truth.room: 0}, [truth]
        for here in left:
            for direction in DIRECTIONS:
                there = walk(lab, here, direction)
                if there.room not in seen:
                    seen[there.room] = seen[here.room] + ahead.get(direction, 0)
                    left.append(there._replace(found=False))
                if there.found:
                    return not truth.found and seen[there.room] <= 0
        return False


@claim
class Within(Claim[Truth, Gridworld]):
    """True if the treasure, not yet found, can be reached from here with at most `moves` moves."""

    kind = FP
    moves: Annotated[int, Range(1, 999)]
    counterparts = Claim.varied("moves", lambda claim, _, __: range(2, claim.moves))

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Measure by breadth-first search."""
        return not moment.after.found and _distance(moment.after) <= self.moves


@claim
class _Kept(Claim[Truth, Gridworld]):
    """Base of claims about the kind of the treasure's room."""

    scope = Scope.WORLD
    room: str
    """Kind of room, such as `kitchen`."""
    one = slot(article, "room")
    counterparts = Claim.varied("room", lambda _, moment, __: sorted(set(map(kind_of, moment.after.layout.names))))


@claim
class InRoom(_Kept):
    """True if the treasure lies in a room of this kind."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look around in every room."""
        return _where(moment.after, lab) == self.room

    def excludes(self, other: Claim) -> bool:
        """Another kind of room, or the denial of this one."""
        return isinstance(other, _Kept) and (type(other) is InRoom) == (other.room != self.room)


@claim
class NotInRoom(_Kept):
    """True if the treasure does not lie in a room of this kind, of which the house has some."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Look around in every room."""
        there = self.room in map(kind_of, moment.after.layout.names)
        return there and _where(moment.after, lab) != self.room


@claim
class NextTo(Claim[Truth, Gridworld]):
    """True if a door of the named room leads to the treasure."""

    kind = FP
    scope = Scope.WORLD
    room: str
    counterparts = Claim.varied("room", lambda _, moment, __: moment.after.layout.names)

    def holds(self, moment: Moment[Truth], lab: Gridworld) -> bool:
        """Go through the doors of the room."""
        layout = moment.after.layout
        if self.room not in layout.names:
            return False
        here = Truth(layout.names.index(self.room), False, layout)
        return any(walk(lab, here, direction).found for direction in DIRECTIONS)


@claim
class _Treasures(TownRule[Truth, Gridworld]):
    """Base of rules about the types of the treasures' rooms."""

    rooms: tuple[str, ...]
    """Types of rooms, such as `kitchen`."""
    listing = slot(lambda rooms: listed(map(article, rooms)), "rooms")

    def fits(self, truth: Truth) -> bool:
        """Look up the room of the treasure."""
        return self._allows(kind_of(truth.layout.names[truth.layout.treasure]))

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Compare with the type of room in the law."""
        law = moment.after.layout.law
        return law != "" and self._allows(law)

    def _allows(self, room: str) -> bool:
        """Whether treasures may lie in rooms of this type."""
        return (room in self.rooms) == (self.kind is FP)

    def counterparts(self, moment: Moment[Truth], lab: Gridworld) -> Sequence[Claim]:
        """As many other types of rooms."""
        types = lab.options["room_types"]
        around = ((*types[i:], *types[:i])[: len(self.rooms)] for i in range(len(types)))
        return tuple(type(self)(rooms=rooms) for rooms in around if rooms != self.rooms)


@claim
class TreasuresIn(_Treasures):
    """True if in every house of the town the treasure lies in a room of one of these types."""

    kind = FP

    def excludes(self, other: Claim) -> bool:
        """A claim of only other types, or that it is in none of these."""
        if not isinstance(other, _Treasures):
            return False
        both = set(self.rooms) & set(other.rooms)
        return not both if isinstance(other, TreasuresIn) else len(both) == len(self.rooms)


@claim
class NoTreasuresIn(_Treasures):
    """True if in no house of the town the treasure lies in a room of one of these types."""

    kind = FN


def _where(truth: Truth, lab: Gridworld) -> str:
    """The kind of room where the treasure is."""
    for room, name in enumerate(truth.layout.names):
        lab.restore(Truth(room, False, truth.layout))
        if lab.observe()["objects"][-1]:
            return kind_of(name)
    return ""


def _in_words(room: str, doors: tuple[str, ...], objects: tuple[str, ...]) -> str:
    """A room with its objects and doors, such as `kitchen-1 (clock): north attic-1, east hall-2`."""
    inside = f" ({', '.join(objects)})" if objects else ""
    ways = (f"{direction} {behind}" for direction, behind in zip(DIRECTIONS, doors, strict=False) if behind)
    return f"{room}{inside}: {', '.join(ways)}"


def walk(lab: Gridworld, truth: Truth, direction: Direction) -> Truth:
    """Where a move leads."""
    lab.restore(truth)
    lab.advance(direction)
    return lab.truth


def _gain(lab: Gridworld, truth: Truth, direction: Direction) -> int:
    return _distance(truth) - _distance(walk(lab, truth, direction))


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
