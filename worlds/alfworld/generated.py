"""Games generated from a seed: a task, a floor plan that allows it, and places of objects."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from worlds.alfworld.facts import tasks, things
from worlds.alfworld.games import TASKS, Game, compose, goal_pddl
from worlds.alfworld.plans import (
    APPLIANCES,
    LAMPS,
    Plan,
    Receptacle,
    errands,
    location,
    metres,
    name,
    plan,
    plans_for,
    portable,
)

_PREDICATES = ("Cleanable", "Heatable", "Coolable", "Toggleable", "Sliceable")
_DRAWS = 2000  # enough for any house
_COPIES = (1, 1, 2, 3)  # of an object, drawn uniformly
_UNIT = tuple(step / 1000 for step in range(1000))


_NO_LAW: Mapping[str, str] = MappingProxyType({})


def make(rng: np.random.Generator, task: str, split: str, law: Mapping[str, str] = _NO_LAW) -> Game:
    """Generate a game.

    Args:
        rng: random generator.
        task: type of the task; empty: any.
        split: split of the floor plans.
        law: for each type of object, the type of receptacle where a town keeps it; empty without a town.
    """
    draws = iter(rng.random(_DRAWS).tolist())

    def pick(options: Sequence[Any]) -> Any:
        return options[int(next(draws) * len(options))]

    task = task or pick(TASKS)
    here = plan(pick(plans_for(task, split)))
    errand = pick(errands(here.number, task))
    lying: dict[str, Lying] = {}
    for kind, (where, counts) in placements(here, task, errand).items():
        where = kept(where, law.get(kind.lower(), ""))
        count = pick(counts) if len(counts) > 1 else counts[0]
        for _ in range(count if where else 0):
            put(lying, kind, pick(where), pick)
    start = begin(here, pick)
    game = furnished(here, task, errand, pick(tasks()[task].templates), lying, start)
    return game._replace(law=tuple(law.items())) if law else game


def draw_law(rng: np.random.Generator) -> dict[str, str]:
    """The law of a town: for each type of object one of the `keepers`."""
    return {kind: places[rng.integers(len(places))] for kind, places in keepers().items()}


@cache
def keepers() -> dict[str, tuple[str, ...]]:
    """For each type of object that can be carried, the types of receptacles that may hold it; all in lower case."""
    holds = things().holds
    return {
        kind.lower(): tuple(sorted(holder.lower() for holder, held in holds.items() if kind in held))
        for kind in sorted(portable())
    }


def kept(where: tuple[Receptacle, ...], place: str) -> tuple[Receptacle, ...]:
    """The receptacles of the type where the town keeps the object; all receptacles, if none has this type."""
    return tuple(each for each in where if each.type.lower() == place) or where


Errand = tuple[str, str, str]
"""The types of the object, the destination and the lamp of a task, each possibly empty."""
Pick = Callable[[Sequence[Any]], Any]
"""Draws one of several things, each with the same probability."""


class Lying(NamedTuple):
    """An object and its receptacle."""

    id: str
    type: str
    holder: Receptacle


class Placement(NamedTuple):
    """How objects of a type are placed."""

    where: tuple[Receptacle, ...]
    """The receptacles among which each object gets a random one."""
    counts: tuple[int, ...]
    """Numbers of objects, each with the same probability; if there is no receptacle, there are none."""


def placements(here: Plan, task: str, errand: Errand) -> dict[str, Placement]:
    """Per type of object in a floor plan, how its objects are placed, so that the task is not done at the start."""
    target, destination, _ = errand
    barred = {destination, APPLIANCES.get(task, ("",))[0]}
    found = {}
    for kind in here.types:
        if kind == "DeskLamp":
            where = tuple(each for each in here.receptacles if each.type in LAMPS)
            found[kind] = Placement(tuple(each for each in where if each.type == "Desk") or where, (1,))
        elif kind in portable():
            bar = barred if kind == target else ()
            where = tuple(each for each in here.holders[kind] if each.type not in bar)
            least = 2 if kind == target and task == "pick_two_obj_and_place" else 1
            found[kind] = Placement(where, tuple(max(least, count) for count in _COPIES))
    return found


def put(lying: dict[str, Lying], kind: str, holder: Receptacle, pick: Pick) -> None:
    """Put one more object of a type at a random spot of a receptacle."""
    _, x, y, z, *_ = holder.id.split("|")
    while True:
        spot = (metres(float(x) + 0.6 * pick(_UNIT) - 0.3), metres(float(y) + 0.05))
        id = f"{kind}|{spot[0]}|{spot[1]}|{metres(float(z) + 0.6 * pick(_UNIT) - 0.3)}"
        if id not in lying:
            break
    lying[id] = Lying(id, kind, holder)


def begin(here: Plan, pick: Pick) -> str:
    """A location from which no receptacle is used."""
    taken = {each.location for each in here.receptacles}
    while True:
        x, z = pick(here.points)
        start = location(x, z, 90 * pick(range(4)), 30)
        if start not in taken:
            return start


def furnished(here: Plan, task: str, errand: Errand, template: str, lying: dict[str, Lying], start: str) -> Game:
    """The game of a floor plan with these objects, for a task in the words of a template, from a start."""
    target, destination, lamp = errand
    words = {"obj": target, "recep": destination, "toggle": lamp, "mrecep": ""}
    goal = template.format(**{key: each.lower() for key, each in words.items()})
    kinds, facts = _objects_and_facts(here, tuple(lying.values()), start, target)
    problem = [f"(define (problem plan_{here.number})", "(:domain alfred)", "(:objects", *kinds]
    problem += [")", "(:init", *(f"({fact})" for fact in facts), ")", goal_pddl(task, words)]
    return compose(
        "\n".join(problem),
        task,
        words,
        goal,
        [(thing, kind) for thing, _, kind in map(str.split, "\n".join(kinds).lower().splitlines())],
        [tuple(fact.split()) for fact in "\n".join(facts).lower().splitlines()],
    )


def _objects_and_facts(here: Plan, lying: tuple[Lying, ...], start: str, target: str) -> tuple[list[str], list[str]]:
    """The objects of a problem in PDDL, each with its type, and the facts at the start.

    Four types must always be declared, since the domain names them.
    """
    known, called = things(), here.pddl
    kinds = {each.type for each in lying} | {"Knife", "ButterKnife", target}
    holding = {each.type for each in here.receptacles} | {"SinkBasin", "Microwave", "Fridge"}
    names = {each.id: name(each.id) for each in lying}
    places = sorted({each.location for each in here.receptacles} | {start})
    first = name(start)
    objects = ["agent1 - agent"]
    objects += [f"{each}Type - otype" for each in sorted(kinds)] + [f"{each}Type - rtype" for each in sorted(holding)]
    objects += [f"{names[id]} - object" for id in sorted(names)]
    objects += [f"{called[each.id]} - receptacle" for each in here.receptacles]
    objects += [f"{called.get(each, first)} - location" for each in places]
    facts = [f"atLocation agent1 {first}"]
    for id, kind, place in here.receptacles:
        holder = called[id]
        facts += [f"receptacleType {holder} {kind}Type", f"receptacleAtLocation {holder} {called[place]}"]
        if kind in known.openable:
            facts.append(f"openable {holder}")
    for kind in sorted({each.type for each in here.receptacles}):
        facts += [f"canContain {kind}Type {each}Type" for each in known.holds[kind] if each in kinds]
    for id, kind, (holder, _, place) in lying:
        thing = names[id]
        facts += [f"objectType {thing} {kind}Type", f"inReceptacle {thing} {called[holder]}"]
        facts.append(f"objectAtLocation {thing} {called[place]}")
        if kind in portable():
            facts.append(f"pickupable {thing}")
        if kind in known.hollow:
            facts.append(f"isReceptacleObject {thing}")
        facts += [f"{predicate.lower()} {thing}" for predicate in _PREDICATES if kind in known.able[predicate]]
    return objects, facts
