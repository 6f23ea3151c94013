"""The check of claims about commands: a search for the fewest commands of a task, independent of the planner."""

import heapq
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, pairwise, permutations
from threading import Lock
from typing import NamedTuple

from worlds.alfworld import Truth
from worlds.alfworld.exact import USES, ExactEngine
from worlds.alfworld.games import Fact, Game

TREATMENTS = {
    "pick_clean_then_place_in_recep": "clean",
    "pick_heat_then_place_in_recep": "heat",
    "pick_cool_then_place_in_recep": "cool",
}
"""The verb that treats an object, by task."""
IDLE = ("close", "examine", "help", "inventory", "look", "slice")
"""Verbs of commands that bring no task nearer."""
FAR = 10**6
"""More commands than any task needs."""


def verb_of(command: str) -> str:
    """The verb of a command: its first word."""
    return command.split()[0]


def thing_of(command: str) -> str:
    """The first thing that a command names, such as `mug 1`."""
    words = command.removeprefix("go to ").split()
    words = words if command.startswith("go to ") else words[1:]
    return " ".join(words[:2])


class _Search:
    """The fewest commands of a task, by A* in the exact engine; independent of the planner's choices."""

    def __init__(self, game: Game) -> None:
        self.game = game
        self._engine = ExactEngine(game)
        self._known: dict[frozenset[Fact], int] = {}
        self._lock = Lock()

    def distance(self, facts: frozenset[Fact]) -> int:
        """The length of a shortest plan for the task.

        Raises:
            ValueError: there is no plan.
        """
        key = _essence(facts)
        with self._lock:
            if key not in self._known:
                if len(self._known) > _REMEMBERED:
                    self._known.clear()
                self._known[key] = self._search(facts)
            return self._known[key]

    def _search(self, start: frozenset[Fact]) -> int:
        engine, order = self._engine, count()
        engine.load(start)
        least = self._least()
        queue = [(least, next(order), 0, start)] if least < FAR else []
        best = {_essence(start): 0}
        while queue:
            _, _, spent, facts = heapq.heappop(queue)
            if spent > best[_essence(facts)]:
                continue
            engine.load(facts)
            if engine.won():
                return spent
            for command in self._useful():
                engine.load(facts)
                engine.do(command)
                after = engine.facts
                key = _essence(after)
                if spent + 1 < best.get(key, FAR):
                    best[key] = spent + 1
                    # Of equal estimates the deeper one goes first.
                    heapq.heappush(queue, (spent + 1 + self._least(), -next(order), spent + 1, after))
        raise ValueError(f"the task {self.game.goal!r} cannot be done from here")

    def _useful(self) -> Iterator[str]:
        """The commands whose effects can be part of a shortest plan."""
        engine, game = self._engine, self.game
        house = engine.house
        for command in engine.commands():
            verb = verb_of(command)
            if verb in IDLE:
                continue
            if verb in ("go", "open"):
                receptacle = house.id[thing_of(command)]
                kind = house.type[receptacle]
                wanted = (f"{game.target}type", f"{game.lamp}type")
                if (
                    kind != f"{game.destination}type"
                    and kind != USES.get(TREATMENTS.get(game.task, ""), ("",))[0]
                    and not any(house.type[each] in wanted for each in engine.inside[receptacle])
                    and not any((kind, house.type[each]) in house.holds for each in engine.held)
                ):
                    continue
            elif verb == "take" and house.type[house.id[thing_of(command)]] != f"{game.target}type":
                continue
            yield command

    def _least(self) -> int:
        """A lower bound of the commands that the engine's state still needs."""
        engine, game = self._engine, self.game
        if engine.won():
            return 0
        house = engine.house
        targets = [each for each in house.objects if house.type[each] == f"{game.target}type"]
        stored = {each: receptacle for receptacle, inside in engine.inside.items() for each in inside}
        goals = [each for each in house.receptacles if house.type[each] == f"{game.destination}type"]
        tours = []
        if game.task == "pick_two_obj_and_place":
            there = [sum(stored.get(each) == goal for each in targets) for goal in goals]
            for share in set(there):
                ends = [goal for goal, number in zip(goals, there, strict=True) if number == share]
                rest = [each for each in targets if len(ends) > 1 or stored.get(each) != ends[0]]
                tours += [self._stages(order, stored, ends) for order in permutations(rest, 2 - share)]
        else:
            tours = [self._stages((each,), stored, goals) for each in targets]
        return min(map(self._tour, tours), default=FAR)

    def _stages(self, order: Sequence[str], stored: Mapping[str, str], goals: list[str]) -> "list[_Stage]":
        """The stages that every plan for these objects has, one after the other."""
        engine, game = self._engine, self.game
        house, verb = engine.house, TREATMENTS.get(game.task, "")
        stages = [_Stage(self._takers(other)) for other in engine.held if other != order[0]]
        for each in order:
            if each not in engine.held:
                stages.append(_Stage([stored[each]] if each in stored else []))
            if game.lamp:
                lamps = [other for other in house.objects if house.type[other] == f"{game.lamp}type"]
                unlit = not any(engine.has("istoggled", lamp) for lamp in lamps)
                stages.append(_Stage([stored[lamp] for lamp in lamps if lamp in stored], int(unlit), False))
                continue
            if verb and not engine.has(USES[verb][2], each):
                stages.append(_Stage([r for r in house.receptacles if house.type[r] == USES[verb][0]], 1, False))
            stages.append(_Stage(goals))
        return stages

    def _takers(self, each: str) -> list[str]:
        house = self._engine.house
        return [other for other in house.receptacles if (house.type[other], house.type[each]) in house.holds]

    def _tour(self, stages: "list[_Stage]") -> int:
        """A lower bound of acts, moves and openings for visiting one receptacle of each stage."""
        engine = self._engine
        places = [{engine.location}]
        spent, opened = 0, set[str]()
        for receptacles, acts, reaching in stages:
            if not receptacles:
                return FAR
            spent += acts
            places.append({engine.house.place[each] for each in receptacles})
            # Receptacles that were already counted as opened may be the same ones.
            if reaching and opened.isdisjoint(receptacles) and not any(map(engine.open, receptacles)):
                opened.update(receptacles)
                spent += 1
        return spent + sum(here.isdisjoint(there) for here, there in pairwise(places))


class _Stage(NamedTuple):
    """One thing to do on the way, for `_Search`."""

    receptacles: list[str]
    """The receptacles where it can be done."""
    acts: int = 1
    """Its number of commands there."""
    reaching: bool = True
    """Whether the receptacle must be open."""


_REMEMBERED = 20_000
_GAMES = 16
_ESSENTIAL = frozenset(  # what plans depend on
    ("atlocation", "opened", "inreceptacle", "holds", "isclean", "ishot", "iscool", "istoggled")
)
_SEARCHES: "dict[tuple[str, str], _Search]" = {}  # of the last few games


def _essence(facts: frozenset[Fact]) -> frozenset[Fact]:
    return frozenset(fact for fact in facts if fact[0] in _ESSENTIAL)


def distance(truth: Truth) -> int:
    """The fewest commands that the task needs, found by search."""
    key = truth.game.task, truth.game.problem
    search = _SEARCHES.get(key)
    if search is None:
        if len(_SEARCHES) >= _GAMES:
            _SEARCHES.clear()
        search = _SEARCHES[key] = _Search(truth.game)
    return search.distance(truth.facts)
