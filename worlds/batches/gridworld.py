"""Gridworld in arrays: houses as tables, and the house and room of each row."""

from collections.abc import Sequence
from functools import lru_cache
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
    kind_of,
    look_around,
    names_of,
    view_of,
)

POOL = 16_384
"""Default number of houses in the pool."""
_POOL_SEED = 0x401505


class State(NamedTuple):
    """Truths in arrays. A place is a row of the tables of houses."""

    place: Ints
    """The student's room."""
    base: Ints
    """The first room of the house."""
    found: Bools
    """Whether the treasure has been reached in this episode."""


class Houses(NamedTuple):
    """Tables of houses, with a row per room."""

    doors: npt.NDArray[np.int16]
    """For each direction, the room behind the door; without a door, the room itself. Shape (rooms, 4)."""
    distance: npt.NDArray[np.int16]
    """Number of moves to the treasure."""
    compass: npt.NDArray[np.int8]
    """The sides of the room: see `worlds.gridworld.SIDES`."""
    views: npt.NDArray[np.int8]
    """Doors and objects, as in `worlds.gridworld.view_of`."""
    types: npt.NDArray[np.int16]
    """The type of room, as an index into the world's `room_types`."""


class GridworldBatch(WorldBatch[Truth, State]):
    """Houses with the same number of rooms.

    After a reset with a seed, a row's first house is the one that the world's own reset draws. All later houses come
    from a pool of houses with start and treasure. The world draws the pool at its first use; it is the same for every
    seed.

    Args:
        world: a world with the options of all rows.
        rows: number of rows.
        pool: number of houses in the pool; 0: each house is drawn anew.
    """

    world: Gridworld

    def __init__(self, world: Gridworld, rows: int, *, pool: int = POOL) -> None:
        super().__init__(world, rows)
        if type(pool) is not int or not 0 <= pool <= 10_000_000:
            raise ValueError(f"pool must be an integer from 0 to 10,000,000, got {pool!r}")
        self.states = self._rooms = world.options["num_rooms"]  # type: ignore[misc]  # a ClassVar where it is constant
        self._pool = pool
        self._starts: Ints = np.zeros(0, np.int64)
        places = (rows + pool) * self._rooms  # a house per row, then those of the pool
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
        """Enter the house of each truth into the tables."""
        for row, truth in zip(rows.tolist(), truths, strict=True):
            self._build(row, truth.layout)
        base = rows.astype(np.int64) * self._rooms
        place = base + [truth.room for truth in truths]
        self.state = merged(self.state, rows, State(place, base, np.array([truth.found for truth in truths])))

    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Draw houses, from the pool if there is one."""
        if not self._pool:
            self.load_each(rows, (self.world.draw(rng) for _ in rows))
            return
        if not len(self._starts):
            self._fill()
        chosen = rng.integers(self._pool, size=len(rows))
        base = (self.rows + chosen) * self._rooms
        fresh = State(base + self._starts[chosen], base, np.zeros(len(rows), bool))
        self.state = merged(self.state, rows, fresh)

    def _fill(self) -> None:
        """Enter the houses of the pool."""
        houses, self._starts = _pool_of(tuple(self.world.options.items()), self._pool)
        tables: tuple[npt.NDArray[Any], ...] = self.houses
        for table, pooled in zip(tables, houses, strict=True):
            table[self.rows * self._rooms :] = pooled

    def _build(self, number: int, layout: Layout) -> None:
        """Enter a house into the tables at this number."""
        doors = layout.doors
        distance = distances_from(layout.treasure, doors)
        rooms, things = range(len(doors)), self.world.things
        here = slice(number * self._rooms, (number + 1) * self._rooms)
        houses = self.houses
        houses.doors[here] = [[room if to == NO_DOOR else to for to in doors[room]] for room in rooms]
        houses.distance[here] = distance
        houses.compass[here] = [look_around(room, doors, distance)[1] for room in rooms]
        houses.views[here] = [np.concatenate(view_of(layout, room, things)) for room in rooms]
        houses.types[here] = [self._types[kind_of(name)] for name in layout.names]

    def truth(self, state: State, row: int) -> Truth:
        """The room, and the house as the tables have it."""
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
        layout = Layout(doors, names, tuple(objects), treasure, self.world.law)
        return Truth(place - base, bool(state.found[row]), layout)

    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Move through the doors."""
        base, found = self.state.base[rows], self.state.found[rows]
        place = base + self.houses.doors.ravel().take(self.state.place[rows] * len(DIRECTIONS) + actions)
        arrived = self.houses.distance.take(place) == 0
        first = arrived & ~found
        success = arrived | found
        self.state = merged(self.state, rows, State(place, base, success))
        return Outcome(first.astype(np.float64), success)

    def observe(self) -> dict[str, npt.NDArray[Any]]:
        """The rooms, their doors and their objects."""
        place, base, _ = self.state
        views = self.houses.views.take(place, axis=0)
        return {"room": place - base, "doors": views[:, : len(DIRECTIONS)], "objects": views[:, len(DIRECTIONS) :]}

    def place(self, rows: Rows = ALL) -> Ints:
        """The rooms."""
        room: Ints = self.state.place[rows] - self.state.base[rows]
        return room

    def seen(self, row: int, place: int) -> Any:
        """The observation in a room."""
        self.world.restore(self.truth(self.state, row)._replace(room=place))
        return self.world.observe()


@lru_cache(maxsize=4)
def _pool_of(options: tuple[tuple[str, Any], ...], count: int) -> tuple[Houses, Ints]:
    """The houses of a pool, and the start room in each; cached because drawing them takes seconds.

    A kept pool takes 23 bytes a room with the default options, 7.5 MB in all.
    """
    batch = GridworldBatch(Gridworld(**dict(options)), count, pool=0)
    rng = np.random.default_rng(_POOL_SEED)
    batch.load_each(np.arange(count), (batch.world.draw(rng) for _ in range(count)))
    return batch.houses, batch.place()
