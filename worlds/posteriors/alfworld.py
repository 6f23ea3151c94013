"""Posterior of ALFWorld: generated houses, whose objects are drawn for each type by itself, by rejection."""

from collections.abc import Iterator, Mapping, Sequence, Set
from functools import cache
from math import factorial, prod
from typing import Any, NamedTuple

import numpy as np

from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import AGENT, KNIVES, ExactEngine
from worlds.alfworld.facts import tasks, things
from worlds.alfworld.games import Game
from worlds.alfworld.generated import (
    Errand,
    Lying,
    Placement,
    begin,
    furnished,
    keepers,
    kept,
    placements,
    put,
)
from worlds.alfworld.house import house_of, names
from worlds.alfworld.plans import Plan, Receptacle, errands, name, plan, plans_for, portable
from worlds.posteriors import NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["AlfworldPosterior"]

_BLOCK = 1024
_SHOWING = ("go to ", "open ", "examine ")  # commands that show what is in a place, before its name


_Cell = tuple[str, ...]
"""Names of places, such as `drawer 2`, of which it is known what lies in all of them together."""


class _Found(NamedTuple):
    """What the student has found by looking around."""

    listed: frozenset[str]
    """The places whose contents an answer has listed."""
    reached: frozenset[str]
    """The places from which it could have taken what can be carried."""
    passed: frozenset[_Cell]
    """The places at each location where it has been: lamps there can be used."""
    cut: frozenset[_Cell]
    """The places at each location where it has been with a knife: what is there can be sliced."""
    numbers: dict[str, dict[str, frozenset[int]]]
    """Per type of object and place the numbers of the objects that lay there at the start, found or not."""

    def cells(self, kind: str) -> dict[_Cell, frozenset[int]]:
        """Per cell in which all objects of a type were found, their numbers; no place is in two cells."""
        single = self.listed | (self.reached if kind in _of(portable()) else frozenset())
        wider = self.passed if kind in _of(things().able["Toggleable"]) else frozenset()
        wider |= self.cut if kind in _of(things().able["Sliceable"]) else frozenset()
        rest = (tuple(place for place in cell if place not in single) for cell in sorted(wider))
        there = self.numbers.get(kind, {})
        return {
            cell: frozenset().union(*(there.get(place, ()) for place in cell))
            for cell in dict.fromkeys((*((place,) for place in sorted(single)), *rest))
            if cell
        }


class _Kind(NamedTuple):
    """A way in which objects of a type are placed, given what was found of them."""

    kind: str
    placement: Placement
    known: tuple[tuple[tuple[Receptacle, ...], frozenset[int]], ...]
    """The cells whose contents are known, each with the numbers of the objects in it."""
    unknown: tuple[Receptacle, ...]
    """The other receptacles that may hold them."""
    odds: tuple[float, ...]
    """Per possible number of objects, its probability together with that of as many in each cell as were found."""
    laws: tuple[str, ...]
    """The types of receptacles for which this is the way, if a town keeps the objects there; empty without a town."""


class _House(NamedTuple):
    """A floor plan, and how its objects are placed, given what was found."""

    here: Plan
    kinds: tuple[tuple[_Kind, ...], ...]
    """The ways for each type of object."""
    odds: float


class AlfworldPosterior(Posterior[Truth, Alfworld]):
    """Where objects lie in places that have not been looked into, and how many there are.

    In a town, whose law a student does not know, objects of a type are placed in one of several ways.
    """

    needs = {"games": "generated"}  # noqa: RUF012 (a ClassVar in the base)
    exact = False

    def __init__(self, lab: Alfworld) -> None:
        super().__init__(lab)
        if lab.official:
            raise ValueError(
                "ALFWorld's official games have no posterior: how their houses were furnished is not known; pass "
                "games='generated'"
            )
        if lab.law:
            self.tries *= 10  # type: ignore[misc]  # a law that is improbable may be the only one that agrees

    def openings(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Iterator[Truth]:
        """Draw the floor plan, and the objects of each type until they agree with what was found of that type.

        A few floor plans have the same places as others; then the objects of all types have to agree at once.
        """
        game, dice = turns[0].truth.game, _Dice(rng)
        errand, template = _task_of(game)
        houses = self._houses(game, errand, _found(turns))
        odds = [house.odds for house in houses]
        if not sum(odds) > 0:
            raise NoWorldError("no floor plan of the generator agrees with what the student saw")
        tries, missed = (self.tries, self.tries - 1) if len(houses) == 1 else (1, 0)
        left = self.tries - missed
        while left:
            house = houses[dice.weigh(odds)]
            lying: dict[str, Lying] = {}
            law = {kind: dice.pick(places) for kind, places in keepers().items()} if game.law else {}
            for ways in house.kinds:
                for _ in range(tries):
                    way = ways[dice.weigh([sum(each.odds) for each in ways])] if len(ways) > 1 else ways[0]
                    if (drawn := _strewn(way, dice)) is not None:
                        break
                else:
                    left -= 1
                    break
                lying |= drawn
                if way.laws:
                    law[way.kind.lower()] = dice.pick(way.laws)
            else:
                left = self.tries - missed
                start = begin(house.here, dice.pick)
                made = furnished(house.here, game.task, errand, template, lying, start)
                made = made._replace(law=tuple(law.items()))
                yield Truth(made.start, ExactEngine(made).intro(), False, made)
        raise NoWorldError(f"{self.tries:,} draws in a row do not agree with what was found of some type of object")

    def _houses(self, game: Game, errand: Errand, found: _Found) -> list[_House]:
        """The floor plans that agree with what the student saw; all have the same words for a task."""
        house = house_of(game)
        places = [house.name[each] for each in house.place]
        plans = [
            number
            for number in plans_for(game.task, self.lab.options["split"])
            if list(_called(number).values()) == places and errand in errands(number, game.task)
        ]
        known = (_house(number, game.task, errand, found, bool(game.law)) for number in plans)
        return [each for each in known if each.odds > 0]

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """Numbers of objects, and of those in places where the student has been, and has not."""
        game = turns[0].truth.game
        house = house_of(game)
        been = {_location(turn.truth) for turn in turns}
        lying = [(house.type[fact[1]], fact[2]) for fact in sorted(game.start) if fact[0] == "inreceptacle"]
        places = sorted(house.place, key=house.name.__getitem__)
        wanted = [places.index(place) for kind, place in lying if kind == f"{game.target}type"]
        near = [place for _, place in lying if house.place[place] in been]
        return {
            "objects": len(lying),
            "wanted objects": len(wanted),
            "first place of a wanted object": min(wanted),
            "wanted objects where nobody was": sum(house.place[places[each]] not in been for each in wanted),
            "objects where somebody was": len(near),
            "objects in what can be shut there": sum(place in house.openable for place in near),
            **self._quantities_of_law(game, been),
        }

    def _quantities_of_law(self, game: Game, been: Set[str]) -> dict[str, float]:
        if not game.law:
            return {}
        house, law = house_of(game), dict(game.law)
        place = law[game.target]
        fitting = [each for each in house.place if house.type[each] == f"{place}type"]
        return {
            "law for the wanted objects": keepers()[game.target].index(place),
            "places for them where nobody was": sum(house.place[each] not in been for each in fitting),
        }


class _Dice:
    """Draws from a generator, many numbers at a time."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._numbers = (number for _ in iter(int, 1) for number in rng.random(_BLOCK).tolist())

    def pick(self, options: Sequence[Any]) -> Any:
        """One of several things, each with the same probability."""
        return options[int(next(self._numbers) * len(options))]

    def weigh(self, odds: Sequence[float]) -> int:
        """The index of one of several things, by their odds."""
        left = next(self._numbers) * sum(odds)
        for i, each in enumerate(odds):
            left -= each
            if left < 0:
                return i
        return max(i for i, each in enumerate(odds) if each)


def _task_of(game: Game) -> tuple[Errand, str]:
    """The types of a task as the floor plans have them, and the template of its words."""
    words = game.target, game.destination, game.lamp
    known = (each for number in plans_for(game.task, "all") for each in errands(number, game.task))
    errand = next((each for each in known if tuple(map(str.lower, each)) == words), ("", "", ""))
    named = dict(zip(("obj", "recep", "toggle", "mrecep"), (*words, ""), strict=True))
    template = next((each for each in tasks()[game.task].templates if each.format(**named) == game.goal), "")
    return errand, template


@cache
def _called(number: int) -> Mapping[str, str]:
    """The names of a floor plan's places, such as `drawer 2`, by id, sorted by these."""
    here = plan(number)
    return names([here.pddl[each.id].lower() for each in here.receptacles])


def _location(truth: Truth) -> str:
    return next(fact[2] for fact in truth.facts if fact[:2] == ("atlocation", AGENT))


@cache
def _of(kinds: frozenset[str]) -> frozenset[str]:
    """Types as facts have them, in lower case."""
    return frozenset(map(str.lower, kinds))


def _found(turns: Sequence[WorldTurn[Truth]]) -> _Found:
    """What the student has found: what answers list, and what is named in the commands that can be carried out."""
    game = turns[0].truth.game
    house = house_of(game)
    listed: set[str] = set()
    reached: set[str] = set()
    passed: set[_Cell] = set()
    cut: set[_Cell] = set()
    for turn in turns:
        facts = turn.truth.facts
        here = house.at.get(_location(turn.truth), ())
        hand = [house.type[fact[2]] for fact in facts if fact[:2] == ("holds", AGENT)]
        for place in here:
            called = house.name[place]
            if "you see" in turn.truth.feedback and turn.action in [f"{verb}{called}" for verb in _SHOWING]:
                listed.add(called)
            if not hand and (place not in house.openable or ("opened", place) in facts):
                reached.add(called)
        cell = tuple(house.name[place] for place in here)
        passed.add(cell)
        if hand and hand[0] in KNIVES:
            cut.add(cell)
    numbers: dict[str, dict[str, frozenset[int]]] = {}
    for _, each, place in sorted(fact for fact in game.start if fact[0] == "inreceptacle"):
        there = numbers.setdefault(house.type[each].removesuffix("type"), {})
        number = int(house.name[each].rpartition(" ")[2])
        there[house.name[place]] = there.get(house.name[place], frozenset()) | {number}
    return _Found(frozenset(listed), frozenset(reached), frozenset(passed), frozenset(cut), numbers)


def _house(number: int, task: str, errand: Errand, found: _Found, lawful: bool) -> _House:
    """A floor plan given what was found, in a town or not; its odds are 0 if that cannot be."""
    here = plan(number)
    known = {kind.lower(): (kind, each) for kind, each in placements(here, task, errand).items()}
    missing = {kind: (kind, Placement((), (0,))) for kind in found.numbers if kind not in known}
    kinds = [_ways(here, kind, each, found.cells(low), lawful) for low, (kind, each) in (known | missing).items()]
    odds = prod((sum(sum(each.odds) for each in ways) for ways in kinds), start=1 / len(errands(number, task)))
    return _House(here, tuple(sorted(kinds, key=lambda ways: not any(each.known for each in ways))), odds)


def _ways(
    here: Plan, kind: str, placement: Placement, cells: Mapping[_Cell, frozenset[int]], lawful: bool
) -> tuple[_Kind, ...]:
    """The ways in which objects of a type are placed, given what was found of it: in a town, one for each law.

    Laws by which a type of receptacle is used that the house does not have are all one way.
    """
    ways: dict[tuple[Receptacle, ...], list[str]] = {}
    laws = keepers().get(kind.lower(), ()) if lawful else ()
    for place in laws or ("",):
        ways.setdefault(kept(placement.where, place), []).append(place)
    return tuple(
        _kind(here, kind, placement._replace(where=where), cells, tuple(places) if laws else (), len(places))
        for where, places in ways.items()
    )


def _kind(
    here: Plan,
    kind: str,
    placement: Placement,
    cells: Mapping[_Cell, frozenset[int]],
    laws: tuple[str, ...],
    weight: int,
) -> _Kind:
    """A way in which objects of a type are placed, given what was found of it; its odds have this weight."""
    where, counts = placement
    named = {_called(here.number)[here.pddl[each.id].lower()]: each for each in where}
    known = tuple((tuple(named[each] for each in cell if each in named), numbers) for cell, numbers in cells.items())
    unknown = tuple(each for place, each in named.items() if not any(place in cell for cell in cells))
    seen = sum(len(numbers) for _, numbers in known)
    greatest = max((number for _, numbers in known for number in numbers), default=0)
    odds = []
    for count in counts if where else (0,):
        others = count - seen
        # There are at least as many as the greatest number that was found.
        odds.append(weight * factorial(count) / factorial(others) / len(counts) if count >= greatest else 0.0)
        for share, number in ((len(unknown), max(others, 0)), *((len(cell), len(numbers)) for cell, numbers in known)):
            odds[-1] *= (share / max(len(where), 1)) ** number
        odds[-1] /= prod(factorial(len(numbers)) for _, numbers in known)
    return _Kind(kind, placement, tuple(each for each in known if each[0]), unknown, tuple(odds), laws)


def _strewn(kind: _Kind, dice: _Dice) -> dict[str, Lying] | None:
    """Objects of a type; None if those in cells that are known have other numbers than were found."""
    where, counts = kind.placement
    lying: dict[str, Lying] = {}
    if not where:
        return lying
    count = counts[dice.weigh(kind.odds)]
    holders = [dice.pick(cell) for cell, numbers in kind.known for _ in numbers]
    for holder in (*holders, *(dice.pick(kind.unknown) for _ in range(count - len(holders)))):
        put(lying, kind.kind, holder, dice.pick)
    ids = sorted(lying, key=lambda id: name(id).lower())  # of the greatest number first
    for cell, wanted in kind.known:
        if wanted and {count - i for i, id in enumerate(ids) if lying[id].holder in cell} != wanted:
            return None
    return lying
