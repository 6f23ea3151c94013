"""ALFWorld's oracle: shortest plans in closed form from the true facts, and what can be said by them.

A task is a few acts in a fixed order (empty the hand, take, treat, put), each at some receptacle. Every way from one
location to another is one command, so a shortest plan is found by trying all choices of objects and receptacles.
"""

from collections.abc import Callable, Iterable, Iterator, Set
from itertools import permutations
from typing import NamedTuple

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.oracles.alfworld.claims import (
    Avoid,
    Commands,
    Do,
    Done,
    Forward,
    Listed,
    Nearer,
    Needless,
    NoNearer,
    NotForward,
    Refused,
    Route,
    Task,
    TriedInVain,
    TriedWell,
    Try,
    seen,
    visible_part,
)
from teachers.oracles.alfworld.search import FAR, IDLE, TREATMENTS, verb_of
from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import AGENT, NOTHING, USES, ExactEngine
from worlds.alfworld.games import Fact, Game

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
        self._verb = TREATMENTS.get(game.task, "")
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


class AlfworldOracle(Oracle[Truth, Alfworld]):
    """Sees everything, what is hidden too. Regret counts commands; nothing is known of a task that cannot be done.

    With the world's option `oracle="explorer"` it judges and advises by what the student has seen, leads it to what it
    has not seen, and gives basic instructions only; regret counts commands that are no step forward.
    """

    max_importance = 8.0

    def __init__(self, scratch: Callable[[], Alfworld]) -> None:
        super().__init__(scratch)
        self._explores = self.lab.options["oracle"] == "explorer"
        if self._explores:
            self.instruction_types = ("b",)  # type: ignore[misc]  # an option of the world takes the others away

    def start(self, truth: Truth) -> None:
        """Get a planner for the game."""
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
        visible = visible_part(truth, self._planner.engine.house)
        plan = self._planner.plan(visible.facts)
        return self._planner.explore(truth) or None if plan is None else plan

    def _known(self, truth: Truth) -> int | None:
        """The length of a shortest plan by what has been seen."""
        plan = self._planner.plan(visible_part(truth, self._planner.engine.house).facts)
        return None if plan is None else len(plan)

    def _forward(self, before: Truth, command: str) -> bool:
        """Whether a command is a step forward for an explorer."""
        house = self._planner.engine.house
        known = self._known(before)
        if known is not None:
            after = self._after(visible_part(before, house), command)
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
        return Task(goal=truth.game.goal), Commands(forms=FORMS), Listed(), Syntax(expected=expected)

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Some first commands: one that is right, and others."""
        self.lab.restore(truth)
        commands = self.lab.commands()
        tried = {*self.plan(truth, 1), *(commands[i] for i in rng.integers(len(commands), size=_TRIES).tolist())}
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
        plan = self.plan(truth, FAR)
        return (Route(actions=plan),) if plan else ()

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        before, action, after = moment.past, moment.action, moment.after
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
            needed, left = self._left(before), self._left(after)
            if needed is not None and left is not None:
                verdict = Nearer(action=action, left=left) if left < needed else NoNearer(action=action)
        if verdict is not None and verdict.kind in kinds:
            claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
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
        commands = self.lab.commands()
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
        commands = [each for each in self.lab.commands() if verb_of(each) not in IDLE]
        gains = [self._gain(truth, self._after(truth, command)) for command in commands]
        # Looking around, which is always possible, gains nothing: one command is lost.
        return min(1.0 - min([0, *(gain for gain in gains if gain is not None)]), self.max_importance)

    def regret(self, moment: Moment[Truth]) -> float:
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
