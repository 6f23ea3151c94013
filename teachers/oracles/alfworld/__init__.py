"""ALFWorld's oracle: shortest plans in closed form from the true facts, and what can be said by them.

A task is a few acts in a fixed order (empty the hand, take, treat, put), each at some receptacle. Every way from one
location to another is one command, so a shortest plan is found by trying all choices of objects and receptacles.
"""

import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from itertools import count, pairwise, permutations
from threading import Lock
from typing import NamedTuple

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim
from teachers.common import Syntax
from teachers.oracle import Oracle
from worlds.alfworld import Truth
from worlds.alfworld.exact import AGENT, NOTHING, USES, ExactEngine, House
from worlds.alfworld.games import Fact, Game
from worlds.world import World

FORMS = (
    "look",
    "inventory",
    "help",
    "go to (receptacle)",
    "open (receptacle)",
    "close (receptacle)",
    "take (object) from (receptacle)",
    "move (object) to (receptacle)",
    "examine (something)",
    "use (object)",
    "heat (object) with (receptacle)",
    "clean (object) with (receptacle)",
    "cool (object) with (receptacle)",
    "slice (object) with (object)",
)
_TREATMENTS = {
    "pick_clean_then_place_in_recep": "clean",
    "pick_heat_then_place_in_recep": "heat",
    "pick_cool_then_place_in_recep": "cool",
}
_IDLE = ("close", "examine", "help", "inventory", "look", "slice")  # verbs of commands that bring no task nearer


@claim
class Task(Claim):
    """True if the task is what `goal` says."""

    goal: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Read what the house itself says at the start, and win by dealing with what is named."""
        game = moment.after.game
        if not ExactEngine(game).intro().endswith(f"Your task is to: {self.goal}."):
            return False
        return all(each in self.goal for each in (game.target, game.destination, game.lamp))


@claim
class Commands(Claim):
    """True if these are the forms of all commands that the house knows."""

    listing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask for help in the house itself."""
        lab.restore(moment.after)
        lab.advance("help")
        forms = [line.split(":")[0].strip() for line in lab.truth.feedback.splitlines()[1:]]
        return sorted(self.listing.split(", ")) == sorted(["help", *forms])


@claim
class Listed(Claim):
    """True if the observation lists the commands that can be carried out, and others come to nothing."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try them all."""
        lab.restore(moment.after)
        observation, _, _, _, info = lab.advance("help")
        commands = info["admissible_commands"]
        return (
            observation.endswith(", ".join(commands))
            and all(_answer(lab, moment.after, command) != NOTHING for command in commands)
            and _answer(lab, moment.after, "go nowhere") == NOTHING
        )


@claim
class TriedWell(Claim):
    """True if `action`, as the first command, brings the task nearer."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return _gain(lab, _begin(moment.after.game), self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action),)


@claim
class TriedInVain(Claim):
    """True if `action`, as the first command, brings the task no nearer."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return _gain(lab, _begin(moment.after.game), self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action),)


@claim
class Route(Claim):
    """True if these commands, in this order, do the task from here, and no shorter sequence does."""

    actions: tuple[str, ...]
    listing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry them out, and search for the length of a shortest plan."""
        if self.listing != ", ".join(self.actions) or len(self.actions) != _distance(moment.after):
            return False
        lab.restore(moment.after)
        successes = [lab.advance(action)[4]["success"] for action in self.actions]
        return successes.index(True) == len(successes) - 1


@claim
class Done(Claim):
    """True if this command has done the task."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again."""
        before = moment.before
        if before is None or before.won or moment.action != self.action:
            return False
        lab.restore(before)
        return lab.advance(self.action)[4]["success"]

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny it."""
        return (NoNearer(action=self.action),)


@claim
class Nearer(Claim):
    """True if this command has brought the task nearer: fewer commands than before are needed, namely `left`."""

    kind = HP
    action: str
    left: int
    """Commands that are still needed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and search from there."""
        return (
            _made(self.action, moment)
            and _gain(lab, moment.before, self.action) > 0
            and _distance(moment.after) == self.left
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict, or another number."""
        return (NoNearer(action=self.action), Nearer(action=self.action, left=self.left + 1))


@claim
class NoNearer(Claim):
    """True if this command has not brought the task nearer: as many commands as before are needed, or more."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and search from there."""
        return _made(self.action, moment) and _gain(lab, moment.before, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Nearer(action=self.action, left=_distance(moment.after)),)


@claim
class Refused(Claim):
    """True if this command could not be carried out, so that nothing happened."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it again."""
        before = moment.before
        if before is None or moment.action != self.action:
            return False
        lab.restore(before)
        listed = self.action in lab.commands()  # type: ignore[attr-defined]
        lab.advance(self.action)
        return not listed and lab.truth.facts == before.facts and lab.truth.feedback == NOTHING

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (Nearer(action=self.action, left=_distance(moment.after)),)


@claim
class Do(Claim):
    """True if `action` begins a shortest plan for a task not yet done; every tied plan counts."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        return not moment.after.won and _gain(lab, moment.after, self.action) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Recommend other commands."""
        lab.restore(moment.after)
        others = [each for each in lab.commands() if each != self.action]  # type: ignore[attr-defined]
        return tuple(Do(action=each) for each in others[:: max(1, len(others) // _OTHERS)])

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The command's verb, then what it is about."""
        thing = _about(self.action)
        return (DoVerb(verb=_verb(self.action)), *((DoAbout(thing=thing),) if thing else ()))


@claim
class DoVerb(Claim):
    """True if a shortest plan begins with a command that starts with `verb`."""

    kind = FP
    verb: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: _verb(command) == self.verb)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another verb."""
        return tuple(DoVerb(verb=verb) for verb in ("go", "open", "take", "move") if verb != self.verb)


@claim
class DoAbout(Claim):
    """True if a shortest plan begins with a command that names `thing`."""

    kind = FP
    thing: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry all such commands out and search from there."""
        return _some(lab, moment.after, lambda command: _about(command) == self.thing)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Something else."""
        lab.restore(moment.after)
        things = {_about(each): None for each in lab.commands()}  # type: ignore[attr-defined]
        return tuple(DoAbout(thing=thing) for thing in things if thing not in ("", self.thing))[:_OTHERS]


@claim
class Avoid(Claim):
    """True if `action` can be carried out, and does not begin a shortest plan for a task not yet done."""

    kind = FN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and search from there."""
        if moment.after.won or _answer(lab, moment.after, self.action) == NOTHING:
            return False
        return _gain(lab, moment.after, self.action) <= 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of what is right."""
        lab.restore(moment.after)
        wanted = [each for each in lab.commands() if each.split()[0] not in _IDLE]  # type: ignore[attr-defined]
        return tuple(Avoid(action=each) for each in wanted if _gain(lab, moment.after, each) > 0)[:1]


@claim
class Try(Claim):
    """True if, going by what has been seen, `action` is a step forward, as `_forward` says."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        return not moment.after.won and _forward(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Recommend commands that show nothing."""
        return tuple(Try(action=action) for action in ("inventory", "look", "help"))


@claim
class Needless(Claim):
    """True if `action` can be carried out and, going by what has been seen, is no step forward."""

    kind = FN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out and look, or search the part of the house that has been seen."""
        truth = moment.after
        return not (truth.won or _answer(lab, truth, self.action) == NOTHING or _forward(lab, truth, self.action))

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of what is right."""
        lab.restore(moment.after)
        wanted = [each for each in lab.commands() if each.split()[0] not in _IDLE]  # type: ignore[attr-defined]
        return tuple(Needless(action=each) for each in wanted if _forward(lab, moment.after, each))[:1]


@claim
class Forward(Claim):
    """True if, going by what had been seen, this command was a step forward."""

    kind = HP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and look, or search the part of the house that had been seen."""
        return _made(self.action, moment) and _forward(lab, moment.before, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (NotForward(action=self.action),)


@claim
class NotForward(Claim):
    """True if, going by what had been seen, this command was no step forward."""

    kind = HN
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Carry it out again and look, or search the part of the house that had been seen."""
        return _made(self.action, moment) and not _forward(lab, moment.before, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Forward(action=self.action),)


_OTHERS = 6


def _verb(command: str) -> str:
    return command.split()[0]


def _about(command: str) -> str:
    """What a command is about: the two words of the first thing that it names."""
    words = command.removeprefix("go to ").split()
    words = words if command.startswith("go to ") else words[1:]
    return " ".join(words[:2])


def _made(action: str, moment: Moment) -> bool:
    return moment.before is not None and not moment.before.won and moment.action == action


def _begin(game: Game) -> Truth:
    return Truth(game.start, "", False, game)


def _answer(lab: World, truth: Truth, command: str) -> str:
    lab.restore(truth)
    lab.advance(command)
    return str(lab.truth.feedback)


def _gain(lab: World, truth: Truth, command: str) -> int:
    """By how many commands a command shortens what is left, found by search."""
    lab.restore(truth)
    lab.advance(command)
    after = lab.truth
    return _distance(truth) - _distance(after)


def seen(truth: Truth, house: House) -> frozenset[str]:
    """The receptacles whose contents the student must have seen, to judge by the facts.

    Of several receptacles at one location, of which an arrival shows but one, those that were opened or examined.
    """
    facts = truth.facts
    visited = {fact[2] for fact in facts if fact[0] in ("atlocation", "not_atlocation")}
    shown = []
    for receptacle, location in house.place.items():
        if location in visited:
            if receptacle in house.openable:
                known = ("opened", receptacle) in facts or ("not_opened", receptacle) in facts
            else:
                known = len(house.at[location]) == 1 or ("checked", receptacle) in facts
            if known:
                shown.append(receptacle)
    return frozenset(shown)


def _visible(truth: Truth, house: House) -> Truth:
    """The truth without what lies in receptacles that have not been looked into."""
    known = seen(truth, house)
    facts = (fact for fact in truth.facts if fact[0] != "inreceptacle" or fact[2] in known)
    return truth._replace(facts=frozenset(facts))


def _forward(lab: World, truth: Truth, command: str) -> bool:
    """Whether a command begins a shortest plan for the part of the house that has been seen.

    If the task cannot be done with that: whether it shows what lies in a receptacle that had not been looked into, or
    leads to one.
    """
    house = House(truth.game)
    visible = _visible(truth, house)
    try:
        left = _distance(visible)
    except ValueError:
        lab.restore(truth)
        here = lab.truth
        lab.advance(command)
        there = lab.truth
        if seen(there, house) > seen(here, house):
            return True
        place = next(fact[2] for fact in there.facts if fact[0] == "atlocation")
        moved = ("atlocation", AGENT, place) not in here.facts
        return moved and not seen(there, house).issuperset(house.at.get(place, ()))
    lab.restore(visible)
    lab.advance(command)
    return _distance(lab.truth) < left


def _some(lab: World, truth: Truth, fits: Callable[[str], bool]) -> bool:
    if truth.won:
        return False
    lab.restore(truth)
    return any(fits(each) and _gain(lab, truth, each) > 0 for each in lab.commands())  # type: ignore[attr-defined]


class _Search:
    """How many commands a task needs at least, by A* in the exact engine; knows nothing of the planner's choices."""

    def __init__(self, game: Game) -> None:
        self.game = game
        self._engine = ExactEngine(game)
        self._known: dict[frozenset[Fact], int] = {}
        self._lock = Lock()

    def distance(self, facts: frozenset[Fact]) -> int:
        """The length of a shortest sequence of commands that does the task.

        Raises:
            ValueError: there is none.
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
        queue = [(least, next(order), 0, start)] if least < _FAR else []
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
                if spent + 1 < best.get(key, _FAR):
                    best[key] = spent + 1
                    # Of equal estimates the one that has come farther goes first.
                    heapq.heappush(queue, (spent + 1 + self._least(), -next(order), spent + 1, after))
        raise ValueError(f"the task {self.game.goal!r} cannot be done from here")

    def _useful(self) -> Iterator[str]:
        """The commands whose effects can be part of a shortest plan."""
        engine, game = self._engine, self.game
        house = engine.house
        for command in engine.commands():
            verb = _verb(command)
            if verb in _IDLE:
                continue
            if verb in ("go", "open"):
                receptacle = house.id[_about(command)]
                kind = house.type[receptacle]
                wanted = (f"{game.target}type", f"{game.lamp}type")
                if (
                    kind != f"{game.destination}type"
                    and kind != USES.get(_TREATMENTS.get(game.task, ""), ("",))[0]
                    and not any(house.type[each] in wanted for each in engine.inside[receptacle])
                    and not any((kind, house.type[each]) in house.holds for each in engine.held)
                ):
                    continue
            elif verb == "take" and house.type[house.id[_about(command)]] != f"{game.target}type":
                continue
            yield command

    def _least(self) -> int:
        """A number of commands that are needed in any case, for the state that the engine is in."""
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
        return min(map(self._tour, tours), default=_FAR)

    def _stages(self, order: Sequence[str], stored: Mapping[str, str], goals: list[str]) -> "list[_Stage]":
        """What must be done in any case to deal with these objects, one after the other."""
        engine, game = self._engine, self.game
        house, verb = engine.house, _TREATMENTS.get(game.task, "")
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
        """The acts, and the moves and openings that visiting one receptacle of each stage takes at least."""
        engine = self._engine
        places = [{engine.location}]
        spent, opened = 0, set[str]()
        for receptacles, acts, reaching in stages:
            if not receptacles:
                return _FAR
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
    """Where it can be done."""
    acts: int = 1
    """Commands that it takes there."""
    reaching: bool = True
    """Whether the receptacle must be open."""


_FAR = 10**6
_REMEMBERED = 20_000
_GAMES = 16
_ESSENTIAL = frozenset(  # what plans depend on
    ("atlocation", "opened", "inreceptacle", "holds", "isclean", "ishot", "iscool", "istoggled")
)
_SEARCHES: "dict[tuple[str, str], _Search]" = {}  # of the last few games


def _essence(facts: frozenset[Fact]) -> frozenset[Fact]:
    return frozenset(fact for fact in facts if fact[0] in _ESSENTIAL)


def _distance(truth: Truth) -> int:
    """Commands that are needed at least, found by search."""
    key = truth.game.task, truth.game.problem
    search = _SEARCHES.get(key)
    if search is None:
        if len(_SEARCHES) >= _GAMES:
            _SEARCHES.clear()
        search = _SEARCHES[key] = _Search(truth.game)
    return search.distance(truth.facts)


class _Leg(NamedTuple):
    """A beginning of a plan."""

    location: str
    opened: frozenset[str]
    """Receptacles that it has opened."""
    commands: tuple[str, ...]


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
        self._verb = _TREATMENTS.get(game.task, "")
        self._appliances: tuple[str, ...] = ()
        if self._verb:
            appliance, able, self._made, _ = USES[self._verb]
            self._appliances = tuple(each for each in house.receptacles if house.type[each] == appliance)
            self._targets = tuple(each for each in self._targets if each in house.able_to(able))

    def _of_type(self, ids: Iterable[str], kind: str) -> tuple[str, ...]:
        house = self.engine.house
        return tuple(each for each in ids if house.type.get(each) == f"{kind}type")

    def plan(self, facts: frozenset[Fact]) -> tuple[str, ...] | None:
        """A shortest sequence of commands that does the task; None if there is none."""
        engine = self.engine
        engine.load(facts)
        if engine.won():
            return ()
        self._stored = {each: receptacle for receptacle, inside in engine.inside.items() for each in inside}
        begin = _Leg(engine.location, frozenset(), ())
        ends = self._pairs(begin) if self.game.task == "pick_two_obj_and_place" else self._singles(begin)
        return min((end.commands for end in ends), key=len, default=None)

    def explore(self, truth: Truth) -> tuple[str, ...]:
        """Commands that show what lies in a receptacle not looked into yet, likely ones and near ones first."""
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
        leg = self._go(_Leg(engine.location, frozenset(), ()), goal)
        if goal in house.openable:
            leg = self._reach(leg, goal)
        elif len(house.at[leg.location]) > 1:
            leg = leg._replace(commands=(*leg.commands, f"examine {name[goal]}"))
        return leg.commands

    def _singles(self, begin: _Leg) -> Iterator[_Leg]:
        """Plans for one object: empty the hand, take, treat, put or hold under a lamp."""
        engine = self.engine
        for target in self._targets:
            if target not in engine.held and target not in self._stored:
                continue
            legs = self._freed(begin, target)
            if target not in engine.held:
                legs = [self._take(leg, target) for leg in legs]
            if self.game.lamp:
                for leg in legs:
                    yield from self._lit(leg)
                continue
            if self._verb and not engine.has(self._made, target):
                legs = [self._treat(leg, target, each) for leg in legs for each in self._appliances]
            for leg in legs:
                for receptacle in self._destinations:
                    yield self._put(leg, target, receptacle)

    def _lit(self, leg: _Leg) -> Iterator[_Leg]:
        name = self.engine.house.name
        for lamp in self._lamps:
            if lamp in self._stored:
                there = self._go(leg, self._stored[lamp])
                lit = self.engine.has("istoggled", lamp)
                yield there if lit else there._replace(commands=(*there.commands, f"use {name[lamp]}"))

    def _pairs(self, begin: _Leg) -> Iterator[_Leg]:
        """Plans for two objects: put as many as are missing into the same receptacle."""
        engine = self.engine
        for receptacle in self._destinations:
            rest = [each for each in self._targets if self._stored.get(each) != receptacle]
            rest = [each for each in rest if each in self._stored or each in engine.held]
            missing = 2 - sum(self._stored.get(each) == receptacle for each in self._targets)
            for order in permutations(rest, missing):
                for leg in self._freed(begin, order[0]):
                    for each in order:
                        if each in engine.held and each is not order[0]:
                            break
                        leg = leg if each in engine.held else self._take(leg, each)
                        leg = self._put(leg, each, receptacle)
                    else:
                        yield leg

    def _freed(self, leg: _Leg, target: str) -> list[_Leg]:
        """The ways to lay down what is held, if it is not the target; those that can be worth while."""
        engine = self.engine
        house = engine.house
        junk = [each for each in engine.held if each != target]
        if not junk:
            return [leg]
        kind = house.type.get(junk[0], "")
        ways = [
            self._put(leg, junk[0], each) for each in house.receptacles if (house.type.get(each), kind) in house.holds
        ]
        # Going on from the best of them to where another one ends takes two more commands at most: go and open.
        least = min((len(way.commands) for way in ways), default=0)
        return [way for way in ways if len(way.commands) <= least + 1]

    def _go(self, leg: _Leg, receptacle: str) -> _Leg:
        location = self.engine.house.place[receptacle]
        if location == leg.location:
            return leg
        return _Leg(location, leg.opened, (*leg.commands, f"go to {self.engine.house.name[receptacle]}"))

    def _reach(self, leg: _Leg, receptacle: str) -> _Leg:
        leg = self._go(leg, receptacle)
        if self.engine.open(receptacle) or receptacle in leg.opened:
            return leg
        command = f"open {self.engine.house.name[receptacle]}"
        return _Leg(leg.location, leg.opened | {receptacle}, (*leg.commands, command))

    def _take(self, leg: _Leg, each: str) -> _Leg:
        name, receptacle = self.engine.house.name, self._stored[each]
        leg = self._reach(leg, receptacle)
        return leg._replace(commands=(*leg.commands, f"take {name[each]} from {name[receptacle]}"))

    def _treat(self, leg: _Leg, each: str, appliance: str) -> _Leg:
        name = self.engine.house.name
        leg = self._go(leg, appliance)
        return leg._replace(commands=(*leg.commands, f"{self._verb} {name[each]} with {name[appliance]}"))

    def _put(self, leg: _Leg, each: str, receptacle: str) -> _Leg:
        name = self.engine.house.name
        leg = self._reach(leg, receptacle)
        return leg._replace(commands=(*leg.commands, f"move {name[each]} to {name[receptacle]}"))


class AlfworldOracle(Oracle):
    """Sees everything, what is hidden too. Regret counts commands; nothing is known of a task that cannot be done.

    With the world's option `oracle="explorer"` it judges and advises by what the student has seen, leads it to what it
    has not seen, and gives basic instructions only; regret counts commands that are no step forward.
    """

    max_importance = 8.0

    def __init__(self, scratch: Callable[[], World]) -> None:
        super().__init__(scratch)
        self._explores = self.lab.options["oracle"] == "explorer"
        if self._explores:
            self.instruction_types = ("b",)

    def start(self, truth: Truth, rng: np.random.Generator) -> None:
        """Get a planner for the game."""
        super().start(truth, rng)
        self._planner = Planner(truth.game)
        self._plans: dict[frozenset[Fact], tuple[str, ...] | None] = {}

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """A shortest plan, or its beginning; nothing once the task is done."""
        plan = None if truth.won else self._plan(truth)
        return plan[: max(n, 0)] if plan else ()

    def _plan(self, truth: Truth) -> tuple[str, ...] | None:
        """A shortest plan; the last ones are remembered."""
        if truth.game is not self._planner.game:
            self._planner, self._plans = Planner(truth.game), {}
        if truth.facts not in self._plans:
            if len(self._plans) > _RECENT:
                self._plans.clear()
            self._plans[truth.facts] = self._explored(truth) if self._explores else self._planner.plan(truth.facts)
        return self._plans[truth.facts]

    def _explored(self, truth: Truth) -> tuple[str, ...] | None:
        """A shortest plan by what has been seen, else the way to something else; None if all has been seen."""
        visible = _visible(truth, self._planner.engine.house)
        plan = self._planner.plan(visible.facts)
        return self._planner.explore(truth) or None if plan is None else plan

    def _known(self, truth: Truth) -> int | None:
        """The length of a shortest plan by what has been seen."""
        plan = self._planner.plan(_visible(truth, self._planner.engine.house).facts)
        return None if plan is None else len(plan)

    def _forward(self, before: Truth, command: str) -> bool:
        """Whether a command is a step forward for an explorer."""
        house = self._planner.engine.house
        known = self._known(before)
        if known is not None:
            after = self._after(_visible(before, house), command)
            gained = self._planner.plan(after.facts)
            return gained is not None and len(gained) < known
        after = self._after(before, command)
        if seen(after, house) != seen(before, house):
            return True
        self._planner.engine.load(after.facts)
        location = self._planner.engine.location
        unseen = set(house.at.get(location, ())) - seen(after, house)
        return bool(unseen) and ("atlocation", AGENT, location) not in before.facts

    def _left(self, truth: Truth) -> int | None:
        plan = self._plan(truth)
        return None if plan is None else len(plan)

    def _gain(self, before: Truth, after: Truth) -> int | None:
        """By how many commands the task has come nearer; None if it is not known."""
        a, b = self._left(before), self._left(after)
        return None if a is None or b is None else a - b

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        expected = self.lab.action_syntax
        return Task(goal=truth.game.goal), Commands(listing=", ".join(FORMS)), Listed(), Syntax(expected=expected)

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """Some first commands: one that is right, and others."""
        self.lab.restore(truth)
        commands = self.lab.commands()  # type: ignore[attr-defined]
        tried = {*self.plan(truth, 1), *(commands[i] for i in self.rng.integers(len(commands), size=_TRIES).tolist())}
        told: list[Claim] = []
        for command in sorted(tried):
            gain = self._gain(truth, self._after(truth, command))
            if gain is not None:
                told.append(TriedWell(action=command) if gain > 0 else TriedInVain(action=command))
        return tuple(told)

    def _after(self, truth: Truth, command: str) -> Truth:
        self.lab.restore(truth)
        self.lab.advance(command)
        return self.lab.truth

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        plan = self.plan(truth, _FAR)
        return (Route(actions=plan, listing=", ".join(plan)),) if plan else ()

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        before, action, after = moment.before, moment.action, moment.after
        if before.won or not (HP in kinds or HN in kinds):
            return
        verdict: Claim | None = None
        if after.won:
            verdict = Done(action=action)
        elif after.feedback == NOTHING:
            verdict = Refused(action=action)
        elif self._explores:
            verdict = Forward(action=action) if self._forward(before, action) else NotForward(action=action)
        else:
            gain = self._gain(before, after)
            if gain is not None:
                left = self._left(after)
                verdict = Nearer(action=action, left=left) if gain > 0 else NoNearer(action=action)
        if verdict is not None and verdict.kind in kinds:
            claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        plan = self.plan(truth, 1)
        if not plan:
            return
        if FP in kinds:
            claims.append(Try(action=plan[0]) if self._explores else Do(action=plan[0]))
        if FN in kinds:
            warning = self._warning(truth, moment.turn)
            if warning is not None:
                claims.append(warning)

    def _warning(self, truth: Truth, turn: int) -> Avoid | Needless | None:
        """A command to avoid: in each turn another one, of those that can be carried out."""
        self.lab.restore(truth)
        commands = self.lab.commands()  # type: ignore[attr-defined]
        for i in range(len(commands)):
            command = commands[(turn * _STRIDE + i) % len(commands)]
            if self._explores:
                if not self._forward(truth, command):
                    return Needless(action=command)
                continue
            gain = self._gain(truth, self._after(truth, command))
            if gain is not None and gain <= 0:
                return Avoid(action=command)
        return None

    def importance(self, truth: Truth) -> float:
        """By how many commands the worst next command puts the task off, more than the best one does."""
        if truth.won or self._left(truth) is None:
            return 0.0
        if self._explores:
            return 1.0
        self.lab.restore(truth)
        commands = [each for each in self.lab.commands() if _verb(each) not in _IDLE]  # type: ignore[attr-defined]
        gains = [self._gain(truth, self._after(truth, command)) for command in commands]
        # Looking around, which is always possible, gains nothing: one command is lost.
        return min(1.0 - min([0, *(gain for gain in gains if gain is not None)]), self.max_importance)

    def regret(self, moment: Moment) -> float:
        """Commands wasted by the last one: none if it began a shortest plan; one if it was not executed."""
        if moment.before is None:
            return 1.0
        if moment.before.won:
            return 0.0
        if self._explores:
            return 0.0 if moment.success else float(not self._forward(moment.before, moment.action))
        gain = 1 if moment.success else self._gain(moment.before, moment.after)
        return 1.0 - gain if gain is not None else 0.0


_TRIES = 3
_RECENT = 100
_STRIDE = 7
