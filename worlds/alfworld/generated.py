"""Games that are made anew by seed: a task, a floor plan that allows it, and what lies where."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from worlds.alfworld.facts import tasks, things
from worlds.alfworld.games import TASKS, Game, goal_pddl, parse
from worlds.alfworld.plans import (
    APPLIANCES,
    LAMPS,
    Plan,
    Receptacle,
    errands,
    location,
    metres,
    plan,
    plans_for,
    portable,
)

_T = TypeVar("_T")

_PREDICATES = ("Cleanable", "Heatable", "Coolable", "Toggleable", "Sliceable")
_DRAWS = 2000  # more than the fullest house needs
_COPIES = (1, 1, 2, 3)  # of an object, drawn uniformly
_UNIT = tuple(step / 1000 for step in range(1000))


def make(rng: np.random.Generator, task: str, split: str) -> Game:
    """A new game.

    Args:
        rng: what to draw from.
        task: the task's type; empty for any.
        split: the floor plans to draw from.
    """
    draws = iter(rng.random(_DRAWS).tolist())

    def pick(options: Sequence[_T]) -> _T:
        return options[int(next(draws) * len(options))]

    task = task or pick(TASKS)
    here = plan(pick(plans_for(task, split)))
    target, destination, lamp = pick(errands(here.number, task))
    lying = _strew(here, task, target, destination, pick)
    x, z = pick(here.points)
    taken = {each.location for each in here.receptacles}
    start = location(x, z, 90 * pick(range(4)), 30)
    while start in taken:
        x, z = pick(here.points)
        start = location(x, z, 90 * pick(range(4)), 30)
    words = {"obj": target, "recep": destination, "toggle": lamp, "mrecep": ""}
    goal = pick(tasks()[task].templates).format(**{key: each.lower() for key, each in words.items()})
    problem = _write(here, lying, start, target, goal_pddl(task, words))
    return parse(problem, task, words, goal)


class _Lying(NamedTuple):
    """An object and where it lies."""

    id: str
    type: str
    holder: Receptacle


def _strew(here: Plan, task: str, target: str, destination: str, pick: Callable[[Any], Any]) -> tuple[_Lying, ...]:
    """Put one to three objects of each type into receptacles that may hold them; the goal is not reached by it."""
    barred = {destination, APPLIANCES.get(task, ("",))[0]}
    least = 2 if task == "pick_two_obj_and_place" else 1
    lying: dict[str, _Lying] = {}
    for kind in here.types:
        if kind == "DeskLamp":
            where = [each for each in here.receptacles if each.type in LAMPS]
            where = [each for each in where if each.type == "Desk"] or where
            count = 1
        elif kind in portable():
            bar = barred if kind == target else ()
            where = [each for each in here.receptacles if kind in things().holds[each.type] and each.type not in bar]
            count = max(least if kind == target else 1, pick(_COPIES))
        else:
            continue
        for _ in range(count if where else 0):
            holder = pick(where)
            _, x, y, z, *_ = holder.id.split("|")
            while True:
                spot = (metres(float(x) + 0.6 * pick(_UNIT) - 0.3), metres(float(y) + 0.05))
                id = f"{kind}|{spot[0]}|{spot[1]}|{metres(float(z) + 0.6 * pick(_UNIT) - 0.3)}"
                if id not in lying:
                    break
            lying[id] = _Lying(id, kind, holder)
    return tuple(lying.values())


def _name(id: str) -> str:
    """An id as a name in PDDL, as ALFRED writes it."""
    for character, word in (("-", "minus"), ("|", "bar"), ("+", "plus"), (".", "dot"), (",", "comma")):
        id = id.replace(character, f"_{word}_")
    return id


def _write(here: Plan, lying: tuple[_Lying, ...], start: str, target: str, goal: str) -> str:
    """A problem in PDDL. Four types of things must be declared since the domain names them."""
    known = things()
    kinds = {each.type for each in lying} | {"Knife", "ButterKnife", target}
    holding = {each.type for each in here.receptacles} | {"SinkBasin", "Microwave", "Fridge"}
    places = sorted({each.location for each in here.receptacles} | {start})
    lines = [f"(define (problem plan_{here.number})", "(:domain alfred)", "(:objects", "agent1 - agent"]
    lines += [f"{each}Type - otype" for each in sorted(kinds)] + [f"{each}Type - rtype" for each in sorted(holding)]
    lines += [f"{_name(each.id)} - object" for each in sorted(lying)]
    lines += [f"{_name(each.id)} - receptacle" for each in here.receptacles]
    lines += [f"{_name(each)} - location" for each in places]
    lines += [")", "(:init", f"(atLocation agent1 {_name(start)})"]
    for place in here.receptacles:
        name = _name(place.id)
        lines += [f"(receptacleType {name} {place.type}Type)", f"(receptacleAtLocation {name} {_name(place.location)})"]
        if place.type in known.openable:
            lines.append(f"(openable {name})")
    for holder in sorted({each.type for each in here.receptacles}):
        lines += [f"(canContain {holder}Type {each}Type)" for each in known.holds[holder] if each in kinds]
    for each in lying:
        name = _name(each.id)
        lines += [f"(objectType {name} {each.type}Type)", f"(inReceptacle {name} {_name(each.holder.id)})"]
        lines.append(f"(objectAtLocation {name} {_name(each.holder.location)})")
        if each.type in portable():
            lines.append(f"(pickupable {name})")
        if each.type in known.hollow:
            lines.append(f"(isReceptacleObject {name})")
        lines += [f"({predicate.lower()} {name})" for predicate in _PREDICATES if each.type in known.able[predicate]]
    return "\n".join([*lines, ")", goal])
