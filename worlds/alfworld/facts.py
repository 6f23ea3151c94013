"""Facts about things, tasks and floor plans, from ALFWorld and ALFRED, whose licences are in NOTICE."""

import json
import tomllib
from functools import cache
from importlib import resources
from typing import NamedTuple

__all__ = ["Room", "Task", "Things", "rooms", "tasks", "things"]

_DATA = resources.files(__package__) / "data"
_STEP = 0.25  # metres between two points of a floor's map


class Things(NamedTuple):
    """Facts about types of things."""

    holds: dict[str, tuple[str, ...]]
    """For each type of receptacle, the types of objects that it may contain, sorted."""
    able: dict[str, frozenset[str]]
    """For each predicate, such as `Cleanable`, the types of objects for which it is true."""
    openable: frozenset[str]
    """The types of receptacles that can be opened."""
    hollow: frozenset[str]
    """The types of objects that may contain others."""


class Task(NamedTuple):
    """A type of task."""

    rooms: frozenset[str]
    """The kinds of rooms for the task."""
    templates: tuple[str, ...]
    """The task in English, with slots for the types of its things."""
    goal: str
    """The goal in PDDL, with the same slots, and `#` for each dash."""


class Room(NamedTuple):
    """The known facts about a floor plan."""

    types: tuple[str, ...]
    """Types of all things in the room, sorted."""
    poses: dict[str, tuple[float, float, float, float]]
    """For each fixture, by id, the pose for using it: x and z in metres, degrees of turning and of looking down."""
    points: tuple[tuple[float, float], ...]
    """Reachable positions: x and z in metres, by z and then x."""
    unseen: bool
    """Whether it is in the split `valid_unseen`."""


@cache
def things() -> Things:
    """The facts about types of things."""
    found = tomllib.loads((_DATA / "things.toml").read_text(encoding="utf-8"))
    return Things(
        {holder: tuple(held) for holder, held in found["holds"].items()},
        {predicate: frozenset(types) for predicate, types in found["able"].items()},
        frozenset(found["openable"]),
        frozenset(found["hollow"]),
    )


@cache
def tasks() -> dict[str, Task]:
    """The types of tasks by name."""
    found = tomllib.loads((_DATA / "tasks.toml").read_text(encoding="utf-8"))
    return {
        name: Task(frozenset(task["rooms"]), tuple(task["templates"]), task["goal"]) for name, task in found.items()
    }


@cache
def rooms() -> dict[int, Room]:
    """The floor plans by number: kitchens, living rooms from 201, bedrooms from 301, bathrooms from 401."""
    found = json.loads((_DATA / "rooms.json").read_text(encoding="utf-8"))
    return {
        int(number): Room(
            tuple(room["types"]),
            {id: tuple(pose) for id, pose in room["poses"].items()},
            _points(room["corner"], room["map"]),
            room["unseen"],
        )
        for number, room in found.items()
    }


def _points(corner: list[float], rows: list[str]) -> tuple[tuple[float, float], ...]:
    """The reachable points of a map, shown as dots; rows extend along x, the first has the least z."""
    x, z = corner
    return tuple(
        (x + _STEP * column, z + _STEP * row)
        for row, cells in enumerate(rows)
        for column, cell in enumerate(cells)
        if cell == "."
    )
