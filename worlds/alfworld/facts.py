"""Facts that houses are made of: what may lie where, what can be done to it, the tasks, and the floor plans.

They are those of ALFWorld and ALFRED, whose licences are in NOTICE.
"""

import json
import tomllib
from functools import cache
from importlib import resources
from typing import NamedTuple

__all__ = ["Room", "Task", "Things", "rooms", "tasks", "things"]

_DATA = resources.files(__package__) / "data"
_STEP = 0.25  # metres between two points of a floor's map


class Things(NamedTuple):
    """What is true of all things of a type."""

    holds: dict[str, tuple[str, ...]]
    """Per type of receptacle the types of objects that may lie in it, sorted."""
    able: dict[str, frozenset[str]]
    """Per predicate, such as `Cleanable`, the types of objects that it is true of."""
    openable: frozenset[str]
    """The types of what can be opened."""
    hollow: frozenset[str]
    """The types of objects in which others may lie."""


class Task(NamedTuple):
    """A type of task."""

    rooms: frozenset[str]
    """The kinds of rooms that it is done in."""
    templates: tuple[str, ...]
    """The task in English, with slots for the types of its things."""
    goal: str
    """The goal in PDDL, with the same slots, and `#` for each dash."""


class Room(NamedTuple):
    """A floor plan, as far as it is known."""

    types: tuple[str, ...]
    """Types of all that is in the room, sorted."""
    poses: dict[str, tuple[float, float, float, float]]
    """Per fixture, by its id, how one stands to use it: x and z in metres, degrees of turning and of looking down."""
    points: tuple[tuple[float, float], ...]
    """Where one can stand: x and z in metres, by z and then x."""
    unseen: bool
    """Whether it is kept for the split `valid_unseen`."""


@cache
def things() -> Things:
    """What is true of things by their types."""
    found = tomllib.loads((_DATA / "things.toml").read_text(encoding="utf-8"))
    return Things(
        {holder: tuple(held) for holder, held in found["holds"].items()},
        {predicate: frozenset(types) for predicate, types in found["able"].items()},
        frozenset(found["openable"]),
        frozenset(found["hollow"]),
    )


@cache
def tasks() -> dict[str, Task]:
    """The types of tasks by their names."""
    found = tomllib.loads((_DATA / "tasks.toml").read_text(encoding="utf-8"))
    return {
        name: Task(frozenset(task["rooms"]), tuple(task["templates"]), task["goal"]) for name, task in found.items()
    }


@cache
def rooms() -> dict[int, Room]:
    """The floor plans by their numbers: kitchens, living rooms from 201, bedrooms from 301, bathrooms from 401."""
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
    """The points of a map where one can stand, shown as dots; rows go along x, the first has least z."""
    x, z = corner
    return tuple(
        (x + _STEP * column, z + _STEP * row)
        for row, cells in enumerate(rows)
        for column, cell in enumerate(cells)
        if cell == "."
    )
