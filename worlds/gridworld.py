"""Gridworld: find the treasure in a house of rooms on a grid.

Each room has at most four doors, one per side. The layout is planar and has cycles, so that there can be
several shortest paths to the treasure.
"""

from collections.abc import Sequence
from enum import IntEnum
from itertools import product
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from worlds.actions import is_element
from worlds.towns import town_stream
from worlds.world import World, illegal

__all__ = [
    "DIRECTIONS",
    "NO_DOOR",
    "OBJECTS",
    "ROOM_TYPES",
    "SIDES",
    "TREASURE",
    "Direction",
    "Gridworld",
    "Layout",
    "Truth",
    "distances_from",
    "kind_of",
    "look_around",
    "names_of",
    "view_of",
]


class Direction(IntEnum):
    """The four actions, numbered as in LLF-Bench; each formats as its name."""

    NORTH = 0
    EAST = 1
    WEST = 2
    SOUTH = 3

    def __str__(self) -> str:
        return _NAMES[self]

    def __format__(self, spec: str) -> str:
        return _NAMES[self]


_PLAIN = (int, Direction)
_NAMES = ("north", "east", "west", "south")
DIRECTIONS = tuple(Direction)
_OFFSETS = ((0, 1), (1, 0), (-1, 0), (0, -1))  # of the cell behind each side
_AHEAD = (0, 1)  # north and east, so that each wall is considered once
ROOM_TYPES = ("attic", "bathroom", "bedroom", "cellar", "hall", "kitchen", "library")
OBJECTS = ("clock", "lamp", "mirror", "plant", "vase")
TREASURE = "treasure"
NO_DOOR = -1
_DOORS = {walls: 1 - np.array(walls, np.int8) for walls in product((False, True), repeat=4)}  # by sides with walls
_NAMED = "of letters, spaces, hyphens and apostrophes"
_ATTEMPTS = 200


class Layout(NamedTuple):
    """The fixed part of an episode; shared by reference between snapshots."""

    doors: tuple[tuple[int, int, int, int], ...]
    """For each room and direction, the room behind the door, or -1."""
    names: tuple[str, ...]
    """For each room, its unique name, such as `kitchen-2`."""
    objects: tuple[tuple[str, ...], ...]
    """For each room, the objects in it, without the treasure."""
    treasure: int
    """The room with the treasure."""
    law: str = ""
    """The type of the rooms with the treasures of the town; empty without a town."""


class Sides(NamedTuple):
    """The four sides of a room."""

    nearer: tuple[Direction, ...]
    """Doors on a shortest path to the treasure."""
    astray: tuple[Direction, ...]
    """Other doors."""
    walls: tuple[Direction, ...]


class Truth(NamedTuple):
    """The state of an episode: the agent's room in a house."""

    room: int
    found: bool
    """Whether the treasure has been reached in this episode."""
    layout: Layout


class Gridworld(World[Truth, dict[str, Any], Direction]):
    """A house of rooms with one treasure.

    Observation: Dict of `room` (Discrete(num_rooms)), `doors` (MultiBinary(4): north, east, west, south)
    and `objects` (MultiBinary(6): clock, lamp, mirror, plant, vase, treasure, or those of `things`), the objects in
    the room.
    Action: Discrete(4), a `Direction`; a move without a door leaves the agent where it is.
    Reward: 1 when the treasure is first reached, else 0. Success stays true from then on; nothing terminates.

    Args:
        num_rooms: rooms in the house, at least 2.
        num_objects: objects placed at random, at least 0; equal ones in the same room count once.
        min_goal_dist: least number of moves from the start to the treasure, 1 to `num_rooms - 1`.
        room_types: types of rooms, at least one; the name of a room is its type and a number.
        object_types: types of objects, at least one.
        treasure: name of the treasure.
        map: whether the teacher's instruction gives the plan of the house; the world itself is the same.
        town: number of a town, at least 0; all treasures of a town lie in rooms of one type. None: in any rooms.

    Names consist of letters, spaces, hyphens and apostrophes.
    """

    reward_range = (0.0, 1.0)
    _truth: Truth = None  # type: ignore[assignment]  # before the first reset
    _views: dict[int, tuple[npt.NDArray[np.int8], npt.NDArray[np.int8]]]  # by room; a turn is an eighth longer without
    action_words = MappingProxyType(dict(zip(_NAMES, DIRECTIONS, strict=True)))
    action_fillers = ("head", "move", "turn", "walk", "step", "way", "door", "side", "direction", "through")
    answer_names = ("direction",)
    action_syntax = "one of north, east, west, south, or its number (0, 1, 2, 3)"

    def __init__(
        self,
        num_rooms: int = 20,
        num_objects: int = 10,
        min_goal_dist: int = 4,
        *,
        room_types: Sequence[str] = ROOM_TYPES,
        object_types: Sequence[str] = OBJECTS,
        treasure: str = TREASURE,
        map: bool = False,
        town: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(
            render_mode=render_mode,
            num_rooms=num_rooms,
            num_objects=num_objects,
            min_goal_dist=min_goal_dist,
            room_types=room_types,
            object_types=object_types,
            treasure=treasure,
            map=map,
            town=town,
        )
        _check("num_rooms", num_rooms, 2, 10_000)
        _check("num_objects", num_objects, 0, 100_000)
        _check(f"with num_rooms={num_rooms} min_goal_dist", min_goal_dist, 1, num_rooms - 1)
        _check_names("room_types", room_types)
        _check_names("object_types", object_types)
        if not _is_name(treasure) or treasure in object_types:
            raise ValueError(f"treasure must be {_NAMED}, and not in object_types, got {treasure!r}")
        if not isinstance(map, bool):
            raise ValueError(f"map must be True or False, got {map!r}")
        rng = town_stream("gridworld", town)
        self.law = room_types[int(rng.integers(len(room_types)))] if rng else ""
        """The type of the rooms with treasures; empty without a town."""
        self.things = (*object_types, treasure)
        """The objects that may be in a room, the treasure last."""
        self.observation_space = spaces.Dict(
            {
                "room": spaces.Discrete(num_rooms),
                "doors": spaces.MultiBinary(len(DIRECTIONS)),
                "objects": spaces.MultiBinary(len(self.things)),
            }
        )
        self.action_space = spaces.Discrete(len(DIRECTIONS))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a new house, start and treasure."""
        super().reset(seed=seed, options=options)
        self._load(self.draw(self.np_random))
        return self.observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The room, whether the treasure was found, and the house."""
        return self._truth

    def legal(self, action: Any) -> Direction:
        """The action as a `Direction`."""
        # Skip Gymnasium's own check for plain actions: it makes a turn a fifth longer.
        if not (type(action) in _PLAIN and 0 <= action < 4) and not is_element(self.action_space, action):
            raise illegal(action, "0 north, 1 east, 2 west, 3 south")
        number: int = action
        return DIRECTIONS[number]

    def advance(self, action: Direction) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Move through the door in a direction, if there is one."""
        room, found, layout = self._truth
        behind = layout.doors[room][action]
        reward = 0.0
        if behind != NO_DOOR:
            if behind == layout.treasure and not found:
                found, reward = True, 1.0
            self._truth = tuple.__new__(Truth, (behind, found, layout))  # in a third of the time of its constructor
        return self.observe(), reward, False, False, {"success": found}

    def observe(self) -> dict[str, Any]:
        """The room, its doors and its objects."""
        room, _, layout = self._truth
        view = self._views.get(room)
        if view is None:
            view = self._views[room] = view_of(layout, room, self.things)
        doors, objects = view
        return {"room": room, "doors": doors.copy(), "objects": objects.copy()}

    def describe(self, observation: dict[str, Any]) -> str:
        """The names of the room, of its objects and of the rooms behind its doors."""
        room = int(observation["room"])
        _, _, layout = self._truth
        things = [name for name, here in zip(self.things, observation["objects"].tolist(), strict=True) if here]
        exits = [
            f"{direction}: {layout.names[layout.doors[room][direction]]}"
            for direction, door in zip(DIRECTIONS, observation["doors"].tolist(), strict=True)
            if door
        ]
        lines = (f"Room: {layout.names[room]}", f"Objects: {', '.join(things) or 'none'}", f"Doors: {', '.join(exits)}")
        return "\n".join(lines)

    def sample_action(self, rng: np.random.Generator) -> Direction:
        """A uniform direction."""
        return DIRECTIONS[rng.integers(len(DIRECTIONS))]

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """A house of 2 to 40 rooms, with any number of objects, any distance to the treasure, with or without a map."""
        rooms = int(rng.integers(2, 41))
        objects, distance = int(rng.integers(3 * rooms)), int(rng.integers(1, rooms))
        plan = bool(rng.integers(2))
        return self.options | {"num_rooms": rooms, "num_objects": objects, "min_goal_dist": distance, "map": plan}

    def _load(self, truth: Truth) -> None:
        if self._truth is None or truth.layout is not self._truth.layout:
            self._views = {}
        self._truth = truth

    def draw(self, rng: np.random.Generator) -> Truth:
        """The start of an episode: a house, a room, and a treasure at least `min_goal_dist` moves away from it."""
        rooms, least = self.options["num_rooms"], self.options["min_goal_dist"]
        for attempt in range(_ATTEMPTS + 1):
            # A house that is too compact is drawn again; if all of them are, it is a corridor.
            doors = _house(rooms, rng) if attempt < _ATTEMPTS else _corridor(rooms)
            start = int(rng.integers(rooms)) if attempt < _ATTEMPTS else 0
            far = [room for room, steps in enumerate(distances_from(start, doors)) if steps >= least]
            if far:
                break
        treasure = far[rng.integers(len(far))]
        return Truth(start, False, self._furnish(doors, treasure, rng))

    def _furnish(self, doors: "_Doors", treasure: int, rng: np.random.Generator) -> Layout:
        """Name the rooms and place the objects."""
        types, things = self.options["room_types"], self.things[:-1]
        rooms, num_objects = len(doors), self.options["num_objects"]
        draws = rng.random(rooms + 2 * num_objects).tolist()
        kinds = [types[int(draw * len(types))] for draw in draws[:rooms]]
        if self.law:
            kinds[treasure] = self.law
        names = names_of(kinds)
        objects: list[tuple[str, ...]] = [()] * rooms
        for place, kind in zip(draws[rooms::2], draws[rooms + 1 :: 2], strict=True):
            room, thing = int(place * rooms), things[int(kind * len(things))]
            if thing not in objects[room]:
                objects[room] = tuple(sorted((*objects[room], thing)))
        behind = tuple((north, east, west, south) for north, east, west, south in doors)
        return Layout(behind, names, tuple(objects), treasure, self.law)


def _check(name: str, value: Any, least: int, most: int) -> None:
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
        raise ValueError(f"{name} must be an integer from {least} to {most}, got {value!r}")


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and value == value.strip() != "" and all(c.isalpha() or c in " -'" for c in value)


def _check_names(name: str, values: Any) -> None:
    listed = isinstance(values, list | tuple) and len(values) > 0
    if not listed or not all(map(_is_name, values)) or len(set(values)) < len(values):
        raise ValueError(f"{name} must be a list of different names, at least one, each {_NAMED}, got {values!r}")


def names_of(types: Sequence[str]) -> tuple[str, ...]:
    """The names of rooms of these types, which are numbered within each type."""
    count = dict.fromkeys(types, 0)
    names = []
    for kind in types:
        count[kind] = number = count[kind] + 1
        names.append(f"{kind}-{number}")
    return tuple(names)


def kind_of(name: str) -> str:
    """The type of the room with this name."""
    return name.rpartition("-")[0]


def view_of(layout: Layout, room: int, things: Sequence[str]) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.int8]]:
    """The doors of a room, int8 (4,), and its objects, int8 (len(things),), the treasure last: 0 or 1 each.

    Rooms with equal doors share the first array: copy it before changing it.
    """
    north, east, west, south = layout.doors[room]
    walls = (north == NO_DOOR, east == NO_DOOR, west == NO_DOOR, south == NO_DOOR)
    objects = np.zeros(len(things), np.int8)
    if here := layout.objects[room]:
        objects[:-1] = [thing in here for thing in things[:-1]]
    objects[-1] = room == layout.treasure
    return _DOORS[walls], objects


def look_around(room: int, doors: Sequence[Sequence[int]], distance: Sequence[int]) -> tuple[list[int], int]:
    """For each direction, the distance to the treasure after that move; and the compass of the room: see `SIDES`.

    Args:
        room: the current room.
        doors: as in `Layout`.
        distance: for each room, the number of moves to the treasure.
    """
    here = distance[room]
    steps = []
    compass = 0
    for side, behind in enumerate(doors[room]):
        if behind == NO_DOOR:
            steps.append(here)
            compass += _PLACES[side] * _WALL
        else:
            steps.append(distance[behind])
            if distance[behind] >= here:
                compass += _PLACES[side] * _ASTRAY
    return steps, compass


def _sides(compass: int) -> Sides:
    """The sides that a compass encodes: its digits, to base 3, are north, east, west and south, the lowest first."""
    digit = {direction: compass // _PLACES[direction] % 3 for direction in DIRECTIONS}
    nearer, astray, walls = (tuple(d for d in DIRECTIONS if digit[d] == what) for what in (_NEARER, _ASTRAY, _WALL))
    return Sides(nearer, astray, walls)


_NEARER, _ASTRAY, _WALL = range(3)
_PLACES = (1, 3, 9, 27)
SIDES = tuple(map(_sides, range(3 ** len(DIRECTIONS))))
"""The sides of a room by its compass, an integer below 81."""


_Doors = list[list[int]]  # for each room and direction, the room behind the door, or NO_DOOR


def distances_from(start: int, doors: Sequence[Sequence[int]]) -> list[int]:
    """Number of moves from a room to each room, by breadth-first search."""
    steps = [-1] * len(doors)
    steps[start] = 0
    queue = [start]
    for room in queue:
        further = steps[room] + 1
        for behind in doors[room]:
            if behind != NO_DOOR and steps[behind] < 0:
                steps[behind] = further
                queue.append(behind)
    return steps


def _house(rooms: int, rng: np.random.Generator) -> _Doors:
    """Add rooms on a grid, each beside an earlier one, then open about half of the other shared walls."""
    cells = [(0, 0)]
    index = {(0, 0): 0}
    doors = [[NO_DOOR] * len(DIRECTIONS) for _ in range(rooms)]
    built = 1
    while built < rooms:
        # Draws in bulk: a scalar draw costs as much as a hundred of these.
        for draw in rng.random(2 * rooms).tolist():
            place = draw * 4
            side = int(place)
            room = int((place - side) * built)
            cell = _behind(cells[room], side)
            if cell not in index:
                index[cell] = built
                cells.append(cell)
                doors[room][side] = built
                doors[built][3 - side] = room  # opposite directions add up to 3
                built += 1
                if built == rooms:
                    break
    walls = [
        (room, side, index[_behind(cell, side)])
        for room, cell in enumerate(cells)
        for side in _AHEAD
        if doors[room][side] == NO_DOOR and _behind(cell, side) in index
    ]
    draws = rng.random(len(walls)).tolist()
    least = min(draws, default=0.0)
    for (room, side, behind), draw in zip(walls, draws, strict=True):
        if draw < 0.5 or draw == least:  # at least one, so that there is a cycle
            doors[room][side] = behind
            doors[behind][3 - side] = room
    return doors


def _behind(cell: tuple[int, int], side: int) -> tuple[int, int]:
    """The cell on a side of a cell."""
    (x, y), (dx, dy) = cell, _OFFSETS[side]
    return x + dx, y + dy


def _corridor(rooms: int) -> _Doors:
    doors = [[NO_DOOR] * len(DIRECTIONS) for _ in range(rooms)]
    for room in range(rooms - 1):
        doors[room][Direction.EAST] = room + 1
        doors[room + 1][Direction.WEST] = room
    return doors
