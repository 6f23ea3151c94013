"""Gridworld in arrays: houses as tables, and in which room of which house each row is."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.batches import ALL, Bools, Ints, Outcome, Rows, WorldBatch, merged
from worlds.batches.streams import Streams
from worlds.gridworld import (
    DIRECTIONS,
    NO_DOOR,
    Gridworld,
    Layout,
    Truth,
    distances_from,
    look_around,
    names_of,
    view_of,
)

POOL = 16_384
"""Houses that episodes are drawn from, if not told otherwise."""
_POOL_SEED = 0x401505


class State(NamedTuple):
    """Truths in arrays. A place is a row of the tables of houses."""

    place: Ints
    """Where the student is."""
    base: Ints
    """The place of the first room of the house."""
    found: Bools
    """Whether the treasure has been reached in this episode."""


class Houses(NamedTuple):
    """Tables of houses, a room a row."""

    doors: npt.NDArray[np.int16]
    """Per direction the room behind the door; where there is none, the room itself. Shape (rooms, 4)."""
    distance: npt.NDArray[np.int16]
    """Moves to the treasure."""
    compass: npt.NDArray[np.int8]
    """How the sides are: see `worlds.gridworld.SIDES`."""
    views: npt.NDArray[np.int8]
    """As `worlds.gridworld.view_of` has it, the doors first."""
    types: npt.NDArray[np.int16]
    """The type of room, as an index into the world's `room_types`."""


class GridworldBatch(WorldBatch[Truth, State]):
    """Houses of equally many rooms.

    A row's first house after a reset with a seed is that of the world's own reset. All others come from a pool of
    houses that the world drew, the same for every seed, with start and treasure; it is made when it is first needed.

    Args:
        world: for its options.
        rows: how many rows.
        pool: houses in the pool; 0: there is none, each house is drawn anew.
    """

    world: Gridworld

    def __init__(self, world: Gridworld, rows: int, *, pool: int = POOL) -> None:
        super().__init__(world, rows)
        if type(pool) is not int or not 0 <= pool <= 10_000_000:
            raise ValueError(f"pool must be an integer from 0 to 10,000,000, got {pool!r}")
        self.states = self._rooms = world.options["num_rooms"]  # type: ignore[misc]  # of the class where it is the same for all
        self._pool, self._starts = pool, np.zeros(0, np.int64)
        places = (rows + pool) * self._rooms  # each row has a house of its own; those of the pool come after them
        self.houses = Houses(
            np.zeros((places, len(DIRECTIONS)), np.int16),
            np.zeros(places, np.int16),
            np.zeros(places, np.int8),
            np.zeros((places, len(DIRECTIONS) + len(world.things)), np.int8),
            np.zeros(places, np.int16),
        )
        self._types = {kind: number for number, kind in enumerate(world.options["room_types"])}
        self.state = State(np.zeros(rows, np.int64), np.zeros(rows, np.int64), np.zeros(rows, bool))

    def load(self, rows: Ints, truths: Sequence[Truth]) -> None:
        """Build each row the house of its truth."""
        for row, truth in zip(rows.tolist(), truths, strict=True):
            self._build(row, truth.layout)
        base = rows.astype(np.int64) * self._rooms
        place = base + [truth.room for truth in truths]
        self.state = merged(self.state, rows, State(place, base, np.array([truth.found for truth in truths])))

    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Take houses of the pool, or draw them."""
        if not self._pool:
            self.load(rows, [self.world.draw(rng) for _ in range(len(rows))])
            return
        if not len(self._starts):
            self._fill()
        chosen = rng.integers(self._pool, size=len(rows))
        base = (self.rows + chosen) * self._rooms
        fresh = State(base + self._starts[chosen], base, np.zeros(len(rows), bool))
        self.state = merged(self.state, rows, fresh)

    def _fill(self) -> None:
        """Draw the houses of the pool."""
        rng = np.random.default_rng(_POOL_SEED)
        starts = []
        for number in range(self._pool):
            truth = self.world.draw(rng)
            self._build(self.rows + number, truth.layout)
            starts.append(truth.room)
        self._starts = np.array(starts)

    def _build(self, number: int, layout: Layout) -> None:
        """Enter a house into the tables."""
        doors = layout.doors
        distance = distances_from(layout.treasure, doors)
        rooms, things = range(len(doors)), self.world.things
        here = slice(number * self._rooms, (number + 1) * self._rooms)
        houses = self.houses
        houses.doors[here] = [[room if to == NO_DOOR else to for to in doors[room]] for room in rooms]
        houses.distance[here] = distance
        houses.compass[here] = [look_around(room, doors, distance)[1] for room in rooms]
        houses.views[here] = [np.concatenate(view_of(layout, room, things)) for room in rooms]
        houses.types[here] = [self._types[name.rpartition("-")[0]] for name in layout.names]

    def truth(self, state: State, row: int) -> Truth:
        """The room, and the house out of the tables."""
        base, place = int(state.base[row]), int(state.place[row])
        here = slice(base, base + self._rooms)
        rooms = np.arange(self._rooms)[:, None]
        north, east, west, south = np.where(
            self.houses.doors[here] == rooms, NO_DOOR, self.houses.doors[here]
        ).T.tolist()
        doors = tuple(zip(north, east, west, south, strict=True))
        kinds, things = self.world.options["room_types"], self.world.things
        objects = [
            tuple(sorted(thing for thing, lies in zip(things[:-1], view[len(DIRECTIONS) : -1], strict=True) if lies))
            for view in self.houses.views[here].tolist()
        ]
        names = names_of([kinds[number] for number in self.houses.types[here].tolist()])
        treasure = int(self.houses.distance[here].argmin())
        return Truth(place - base, bool(state.found[row]), Layout(doors, names, tuple(objects), treasure))

    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Walk through the doors that there are."""
        base, found = self.state.base[rows], self.state.found[rows]
        place = base + self.houses.doors.ravel().take(self.state.place[rows] * len(DIRECTIONS) + actions)
        arrived = self.houses.distance.take(place) == 0
        first = arrived & ~found
        success = arrived | found
        self.state = merged(self.state, rows, State(place, base, success))
        return Outcome(first.astype(np.float64), success)

    def observe(self) -> dict[str, npt.NDArray[Any]]:
        """The rooms, their doors and what lies there."""
        place, base, _ = self.state
        views = self.houses.views.take(place, axis=0)
        return {"room": place - base, "doors": views[:, : len(DIRECTIONS)], "objects": views[:, len(DIRECTIONS) :]}

    def place(self, rows: Rows = ALL) -> Ints:
        """The rooms."""
        room: Ints = self.state.place[rows] - self.state.base[rows]
        return room

    def seen(self, row: int, place: int) -> Any:
        """What the world observes in that room."""
        self.world.restore(self.truth(self.state, row)._replace(room=place))
        return self.world.observe()
