"""Floor plans of AI2-THOR and the tasks that they allow."""

from functools import cache
from typing import NamedTuple

import numpy as np

from worlds.alfworld.facts import rooms, tasks, things

APPLIANCES = {
    "pick_clean_then_place_in_recep": ("SinkBasin", "Cleanable"),
    "pick_heat_then_place_in_recep": ("Microwave", "Heatable"),
    "pick_cool_then_place_in_recep": ("Fridge", "Coolable"),
}
"""For each task with an appliance, its type and the predicate of the objects for it."""
_BASINS = {"Sink": "SinkBasin", "Bathtub": "BathtubBasin"}
_BASE = {basin: base for base, basin in _BASINS.items()}
_SEVERAL = {"StoveBurner": 4, "HandTowelHolder": 2}  # number of fixtures in a set
LAMPS = ("Desk", "SideTable", "Dresser", "DiningTable", "CoffeeTable", "Shelf", "CounterTop")  # receptacles of lamps
_ROOMS = {0: "Kitchen", 2: "LivingRoom", 3: "Bedroom", 4: "Bathroom"}


class Receptacle(NamedTuple):
    """A place for objects in a floor plan."""

    id: str
    type: str
    location: str
    """The location from which it is used."""


class Plan(NamedTuple):
    """A floor plan."""

    number: int
    receptacles: tuple[Receptacle, ...]
    types: tuple[str, ...]
    """Types of all things in the room."""
    points: tuple[tuple[float, float], ...]
    """Reachable positions: x and z in metres."""
    holders: dict[str, tuple[Receptacle, ...]]
    """For each type of object, the receptacles that may hold it."""
    pddl: dict[str, str]
    """The name in PDDL of each receptacle's id and location."""


@cache
def portable() -> frozenset[str]:
    """The types of objects that can be carried."""
    return frozenset(each for inside in things().holds.values() for each in inside)


@cache
def plan(number: int) -> Plan:
    """A floor plan; fixtures without a known position get a random reachable one."""
    types, poses, points, _ = rooms()[number]
    static = things().holds
    found = []
    for id, pose in poses.items():
        base = id.split("|")[0]
        kind = _BASINS.get(base, base)
        if kind in static:
            found.append(Receptacle(id if kind == base else f"{id}|{kind}", kind, location(*pose)))
    known = {each.type for each in found}
    rng = np.random.default_rng(number)
    for kind in types:
        if kind in static and kind not in known:
            for copy in range(_SEVERAL.get(kind, 1)):
                x, z = points[rng.integers(len(points))]
                id = f"{_BASE.get(kind, kind)}|{metres(x)}|+00.90|{metres(z + copy / 100)}"
                turn = 90 * int(rng.integers(4))
                found.append(Receptacle(f"{id}|{kind}" if kind in _BASE else id, kind, location(x, z, turn, 30)))
    found.sort()
    holders = {kind: tuple(each for each in found if kind in static[each.type]) for kind in types}
    return Plan(number, tuple(found), types, points, holders, {id: name(id) for each in found for id in each[::2]})


def name(id: str) -> str:
    """An id as a name in PDDL, as ALFRED writes it."""
    for character, word in (("-", "minus"), ("|", "bar"), ("+", "plus"), (".", "dot"), (",", "comma")):
        id = id.replace(character, f"_{word}_")
    return id


def metres(value: float) -> str:
    """A coordinate as in an id."""
    return f"{value:+06.2f}"


def location(x: float, z: float, turn: float, tilt: float) -> str:
    """The name of a location, as in ALFRED: steps of 25 cm, quarter turns, degrees of looking down."""
    return f"loc|{round(x / 0.25)}|{round(z / 0.25)}|{round(turn / 90)}|{round(tilt)}"


@cache
def errands(number: int, task: str) -> tuple[tuple[str, str, str], ...]:
    """The types of object, destination and lamp of all tasks of a type that a floor plan allows."""
    here, holds = plan(number), things().holds
    if _ROOMS[number // 100] not in tasks()[task].rooms:
        return ()
    kinds = sorted({each.type for each in here.receptacles})
    # There must be a receptacle for the object besides its destination.
    objects = [each for each in here.types if each in portable() and sum(each in holds[kind] for kind in kinds) >= 2]
    if task == "look_at_obj_in_light":
        lit = "DeskLamp" in here.types and not set(kinds).isdisjoint(LAMPS)
        return tuple((each, "", "DeskLamp") for each in objects) if lit else ()
    appliance, able = APPLIANCES.get(task, ("", ""))
    if appliance:
        objects = [each for each in objects if each in things().able[able]] * (appliance in kinds)
    return tuple(
        (each, kind, "")
        for each in objects
        for kind in kinds
        if each in holds[kind]
        and kind != appliance
        and any(each in holds[other] for other in kinds if other not in (kind, appliance))
    )


@cache
def plans_for(task: str, split: str) -> tuple[int, ...]:
    """The floor plans that allow tasks of a type; those of `valid_unseen` are in no other split."""
    return tuple(
        number
        for number, room in rooms().items()
        if split == "all" or room.unseen == (split == "valid_unseen")
        if errands(number, task)
    )
