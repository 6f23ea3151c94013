"""Shortest plans in closed form.

A task is a few acts in a fixed order (empty the hand, take, treat, put), each at some receptacle. One command leads
from any location to any other, so trying all choices of objects and receptacles finds a shortest plan. The starting
location changes the length by one command at most: a `PlanTable` has the plans from all locations of a house, and
stays valid until the student does something other than moving that matters to the task.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import permutations
from typing import NamedTuple

from teachers.oracles.alfworld.claims import seen
from teachers.oracles.alfworld.search import TREATMENTS
from worlds.alfworld import Truth
from worlds.alfworld.exact import AGENT, USES, ExactEngine
from worlds.alfworld.games import Fact, Game

_REMEMBERED = 64


class _Stop(NamedTuple):
    """One thing to do at a receptacle."""

    receptacle: str
    location: str
    opens: bool
    """Whether the receptacle must be open, and is closed now."""
    command: str
    """What to do there; empty if arriving is enough."""


_Stops = tuple[_Stop, ...]


class _Choice(NamedTuple):
    """One sequence of stops that does the task."""

    left: int
    """Its number of commands, without the one that leads to its first stop."""
    order: int
    """Its rank among equally short choices; the least wins."""
    stops: _Stops
    lays: bool
    """Whether it begins with putting down the object in the hand."""


class PlanTable:
    """How many commands a task takes from each location, and which.

    Args:
        choices: the ways to do the task, in order: number of commands without the one that leads to the first stop, the
            stops, and whether it begins with putting something down.
        done: the locations where nothing is left to do; "" stands for those without a receptacle.
    """

    def __init__(self, choices: Iterable[tuple[int, _Stops, bool]], done: frozenset[str] = frozenset()) -> None:
        best: dict[tuple[str, bool, bool], _Choice] = {}  # of those that begin alike; it is so from anywhere
        for order, (left, stops, lays) in enumerate(choices):
            begins = stops[0].location, stops[0].opens, lays
            known = best.get(begins)
            if known is None or left < known.left:
                best[begins] = _Choice(left, order, stops, lays)
        self._choices = sorted(best.values())
        self._handy = {location for location, opens, lays in best if lays and not opens}
        self._done = done

    def left(self, location: str) -> int | None:
        """Number of commands left from a location; None if the task is impossible."""
        if location in self._done:
            return 0
        found = self._choose(location)
        return None if found is None else found.left + (found.stops[0].location != location)

    def stops(self, location: str) -> _Stops | None:
        """The stops of a shortest plan from a location; None if the task is impossible."""
        if location in self._done:
            return ()
        found = self._choose(location)
        return None if found is None else found.stops

    def _choose(self, location: str) -> _Choice | None:
        found, least, first = None, 0, 0
        for choice in self._choices:
            left, order, stops, lays = choice
            if found is not None and left > least:
                break
            if stops[0].location != location:
                # To go elsewhere and open something is never worth while where one can lay it down at once.
                if lays and stops[0].opens and location in self._handy:
                    continue
                left += 1
            if found is None or left < least or (left == least and order < first):
                found, least, first = choice, left, order
        return found


class Planner:
    """Shortest plans for a game, from any state.

    Args:
        game: the game.
    """

    def __init__(self, game: Game) -> None:
        self.game = game
        self.engine = ExactEngine(game)
        house = self.engine.house
        self._targets = self._of_type(house.objects, game.target)
        self._destinations = self._of_type(house.receptacles, game.destination)
        self._lamps = self._of_type(house.objects, game.lamp)
        self._verb = TREATMENTS.get(game.task, "")
        self._appliances: tuple[str, ...] = ()
        self._made = "istoggled"
        if self._verb:
            appliance, able, self._made, _ = USES[self._verb]
            self._appliances = tuple(each for each in house.receptacles if house.type[each] == appliance)
            self._targets = tuple(each for each in self._targets if each in house.able_to(able))
        things = (*self._targets, *self._lamps)
        self._matters = frozenset[Fact](
            [("opened", each) for each in house.openable]
            + [("holds", AGENT, each) for each in house.objects]
            + [(self._made, each) for each in things]
            + [("inreceptacle", each, receptacle) for each in things for receptacle in house.receptacles]
        )
        """The facts on which plan tables depend."""
        self._locations = frozenset[Fact](("atlocation", AGENT, each) for each in house.at)
        self._anywhere = frozenset({"", *house.at})
        self._may_hold: dict[str, tuple[str, ...]] = {}
        self._tables: dict[frozenset[Fact], PlanTable] = {}

    def _of_type(self, ids: Iterable[str], kind: str) -> tuple[str, ...]:
        house = self.engine.house
        return tuple(each for each in ids if house.type.get(each) == f"{kind}type")

    def plan(self, facts: frozenset[Fact]) -> tuple[str, ...] | None:
        """A shortest plan for the task; None if there is none."""
        location = self._location(facts)
        stops = self._table(facts).stops(location)
        return None if stops is None else self._commands(location, stops)

    def left(self, facts: frozenset[Fact]) -> int | None:
        """The length of a shortest plan; None if there is none."""
        return self._table(facts).left(self._location(facts))

    def left_after(self, facts: frozenset[Fact], command: str) -> int | None:
        """The length of a shortest plan after another command; None if there is none."""
        way = self.engine.house.ways.get(command)
        if way is not None:
            return self._table(facts).left(way[1])
        self.engine.load(facts)
        self.engine.do(command)
        return self.left(self.engine.facts)

    def explore(self, truth: Truth) -> tuple[str, ...]:
        """Commands that show the content of a new receptacle, the likely and near ones first."""
        engine = self.engine
        house, name = engine.house, engine.house.name
        engine.load(truth.facts)
        known = seen(truth, house)
        unlikely = {
            each: (house.type.get(each, ""), f"{self.game.target}type") not in house.holds for each in house.place
        }
        left = [each for each in house.place if each not in known]
        if not left:
            return ()
        goal = min(left, key=lambda each: (unlikely[each], house.place[each] != engine.location))
        there = house.place[goal]
        hidden = goal not in house.openable and len(house.at[there]) > 1
        look = f"examine {name[goal]}" if hidden else ""
        return self._commands(engine.location, [_Stop(goal, there, not engine.open(goal), look)])

    def _commands(self, location: str, stops: Iterable[_Stop]) -> tuple[str, ...]:
        """The commands for some stops, from a location."""
        name = self.engine.house.name
        commands: list[str] = []
        opened: list[str] = []
        for receptacle, there, opens, command in stops:
            if there != location:
                commands.append(f"go to {name[receptacle]}")
                location = there
            if opens and receptacle not in opened:
                commands.append(f"open {name[receptacle]}")
                opened.append(receptacle)
            if command:
                commands.append(command)
        return tuple(commands)

    def _location(self, facts: frozenset[Fact]) -> str:
        """The agent's location; empty at a place without a receptacle."""
        for fact in facts & self._locations:
            return fact[2]
        return ""

    def _table(self, facts: frozenset[Fact]) -> PlanTable:
        """The plan table of a state; the last ones are cached."""
        key = facts & self._matters
        table = self._tables.get(key)
        if table is None:
            if len(self._tables) >= _REMEMBERED:
                self._tables.clear()
            table = self._tables[key] = self._make_table(key)
        return table

    def _make_table(self, facts: frozenset[Fact]) -> PlanTable:
        self._opened = {fact[1] for fact in facts if fact[0] == "opened"}
        self._stored = {fact[1]: fact[2] for fact in facts if fact[0] == "inreceptacle"}
        self._hand = next((fact[2] for fact in facts if fact[0] == "holds"), "")
        self._laid = [self._put(self._hand, each) for each in self._takers(self._hand)] if self._hand else []
        self._ready = {fact[1] for fact in facts if fact[0] == self._made}
        if self.game.lamp:
            return PlanTable(self._singles(), self._lit())
        if self.game.task == "pick_two_obj_and_place":
            counts = [sum(self._stored.get(each) == there for each in self._targets) for there in self._destinations]
            return PlanTable(self._pairs()) if max(counts, default=0) < 2 else PlanTable((), self._anywhere)
        placed = (each for each in self._targets if self._stored.get(each) in self._destinations)
        if any(not self._verb or each in self._ready for each in placed):
            return PlanTable((), self._anywhere)
        return PlanTable(self._singles())

    def _takers(self, each: str) -> tuple[str, ...]:
        """The receptacles that may hold an object."""
        if each not in self._may_hold:
            house = self.engine.house
            kind = house.type.get(each, "")
            self._may_hold[each] = tuple(r for r in house.place if (house.type.get(r), kind) in house.holds)
        return self._may_hold[each]

    def _lit(self) -> frozenset[str]:
        """The locations of lamps that are on, if the hand holds something to look at under them."""
        house = self.engine.house
        lit = self._ready.intersection(self._lamps, self._stored, house.able_to("toggleable"))
        return frozenset(house.place[self._stored[each]] for each in lit if self._hand in self._targets)

    def _singles(self) -> Iterator[tuple[int, _Stops, bool]]:
        """Plans for one object: empty the hand, take, treat, put or hold under a lamp."""
        for target in self._targets:
            if target != self._hand and target not in self._stored:
                continue
            taken = () if target == self._hand else (self._take(target),)
            ends: list[_Stops]
            if self.game.lamp:
                ends = [(self._light(lamp),) for lamp in self._lamps if lamp in self._stored]
            else:
                ends = [(self._put(target, each),) for each in self._destinations]
                if self._verb and target not in self._ready:
                    treated = [self._treat(target, each) for each in self._appliances]
                    ends = [(stop, *end) for stop in treated for end in ends]
            yield from self._freed(target, [(*taken, *end) for end in ends])

    def _pairs(self) -> Iterator[tuple[int, _Stops, bool]]:
        """Plans for two objects: put the missing ones into the same receptacle."""
        for receptacle in self._destinations:
            rest = [each for each in self._targets if self._stored.get(each) != receptacle]
            rest = [each for each in rest if each in self._stored or each == self._hand]
            puts = {each: (self._put(each, receptacle),) for each in rest}
            stops = {each: puts[each] if each == self._hand else (self._take(each), *puts[each]) for each in rest}
            missing = 2 - sum(self._stored.get(each) == receptacle for each in self._targets)
            for order in permutations(rest, missing):
                if self._hand not in order[1:]:
                    yield from self._freed(order[0], [tuple(stop for each in order for stop in stops[each])])

    def _freed(self, target: str, plans: Sequence[_Stops]) -> Iterator[tuple[int, _Stops, bool]]:
        """The plans; each first puts down the held object if that is not the target."""
        if self._hand in ("", target):
            for stops in plans:
                yield _length(stops), stops, False
            return
        if not plans:
            return
        shortest = min(plans, key=_length)
        left = _length(shortest)
        opened = {receptacle for stops in plans for receptacle, _, opens, _ in stops if opens}
        for laid in self._laid:
            if laid.receptacle in opened:
                then = min(((laid, *stops) for stops in plans), key=_length)
                yield _length(then), then, True
            else:
                went = laid.location != shortest[0].location
                yield laid.opens + 1 + went + left, (laid, *shortest), True

    def _stop(self, receptacle: str, command: str, reaches: bool = True) -> _Stop:
        house = self.engine.house
        opens = reaches and receptacle in house.openable and receptacle not in self._opened
        return _Stop(receptacle, house.place[receptacle], opens, command)

    def _take(self, each: str) -> _Stop:
        name, receptacle = self.engine.house.name, self._stored[each]
        return self._stop(receptacle, f"take {name[each]} from {name[receptacle]}")

    def _treat(self, each: str, appliance: str) -> _Stop:
        name = self.engine.house.name
        return self._stop(appliance, f"{self._verb} {name[each]} with {name[appliance]}", reaches=False)

    def _put(self, each: str, receptacle: str) -> _Stop:
        name = self.engine.house.name
        return self._stop(receptacle, f"move {name[each]} to {name[receptacle]}")

    def _light(self, lamp: str) -> _Stop:
        command = "" if lamp in self._ready else f"use {self.engine.house.name[lamp]}"
        return self._stop(self._stored[lamp], command, reaches=False)


def _length(stops: _Stops) -> int:
    """Number of commands of some stops, without the one that leads to the first."""
    left, location = 0, stops[0].location
    opened: list[str] = []
    for receptacle, there, opens, command in stops:
        if there != location:
            left += 1
            location = there
        if opens and receptacle not in opened:
            left += 1
            opened.append(receptacle)
        if command:
            left += 1
    return left
