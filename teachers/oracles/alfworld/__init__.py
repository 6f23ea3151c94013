"""ALFWorld's oracle: it judges by shortest plans, which it computes in closed form from the true facts."""

from collections import Counter
from collections.abc import Callable, Sequence, Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.oracles.alfworld.claims import (
    AlwaysKept,
    Avoid,
    Commands,
    Do,
    DoAbout,
    Done,
    Forward,
    InTheOpen,
    Kept,
    Listed,
    Nearer,
    Needless,
    NoNearer,
    NotAlwaysKept,
    NotForward,
    NotKept,
    Refused,
    Route,
    ShutIn,
    Task,
    Treat,
    TriedInVain,
    TriedWell,
    Try,
    seen,
    visible_part,
)
from teachers.oracles.alfworld.planning import Planner
from teachers.oracles.alfworld.search import FAR, IDLE, TREATMENTS, thing_of, verb_of
from worlds.alfworld import Alfworld, Truth
from worlds.alfworld.exact import AGENT, NOTHING
from worlds.alfworld.games import Game
from worlds.alfworld.generated import keepers

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


class AlfworldOracle(Oracle[Truth, Alfworld]):
    """Uses all facts, hidden ones included. Regret counts commands; it has no plans for an impossible task.

    With the world's option `oracle="explorer"` it judges and advises by what the student has seen, leads the student to
    places that are new to it, and gives basic instructions only; regret counts commands that are no step forward.
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

    def _planner_of(self, truth: Truth) -> Planner:
        if truth.game is not self._planner.game:
            self._planner = Planner(truth.game)
        return self._planner

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """A shortest plan, or its beginning; nothing once the task is done."""
        if truth.won:
            return ()
        plan = self._explored(truth) if self._explores else self._planner_of(truth).plan(truth.facts)
        return plan[: max(n, 0)] if plan else ()

    def _explored(self, truth: Truth) -> tuple[str, ...] | None:
        """A shortest plan by the facts that were seen, else the way to unseen ones; None if all were seen."""
        planner = self._planner_of(truth)
        plan = planner.plan(visible_part(truth, planner.engine.house).facts)
        return planner.explore(truth) or None if plan is None else plan

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """The treatment of the thing; a place without one; whether one lay in something that opens; a place with one.

        Rules of a town come between these.
        """
        if truth.won:
            return ()
        game, verb = truth.game, TREATMENTS.get(truth.game.task)
        thing = game.target
        treat = (Treat(thing=thing, verb=verb),) if verb else ()
        taken = [] if self._explores else self._taken(game)
        if not taken:
            return treat
        house = self._planner_of(truth).engine.house
        place = taken[0]
        kept = {fact[2] for fact in game.start if fact[0] == "inreceptacle" and house.type[fact[1]] == f"{thing}type"}
        holders = {house.type[each] for each in kept}
        fitting = (house.type[each] for each in house.place if (house.type[each], f"{thing}type") in house.holds)
        free = Counter(sorted(kind for kind in fitting if kind not in holders)).most_common()[-1:]
        return (
            *treat,
            *(NotKept(thing=thing, place=kind.removesuffix("type")) for kind, _ in free),
            (ShutIn if place in house.openable else InTheOpen)(thing=thing),
            *self._rules(truth),
            Kept(thing=thing, place=house.type[place].removesuffix("type")),
        )

    def _taken(self, game: Game) -> list[str]:
        """The places where a shortest plan from the start takes the task's things, in order."""
        planner = self._planner if self._planner.game is game else Planner(game)
        house = planner.engine.house
        plan = [command.rpartition(" from ") for command in planner.plan(game.start) or ()]
        return [house.id[place] for took, word, place in plan if word and took.split()[1] == game.target]

    def _forward(self, before: Truth, command: str) -> bool:
        """Whether a command is a step forward for an explorer."""
        planner = self._planner_of(before)
        house = planner.engine.house
        visible = visible_part(before, house).facts
        known = planner.left(visible)
        if known is not None:
            gained = planner.left_after(visible, command)
            return gained is not None and gained < known
        engine = planner.engine
        engine.load(before.facts)
        engine.do(command)
        after = before._replace(facts=engine.facts)
        if seen(after, house) != seen(before, house):
            return True
        unseen = set(house.at.get(engine.location, ())) - seen(after, house)
        return bool(unseen) and ("atlocation", AGENT, engine.location) not in before.facts

    def _gain(self, truth: Truth, command: str) -> int | None:
        """By how many commands a command shortens the plan; None if there is no plan."""
        planner = self._planner_of(truth)
        return _less(planner.left(truth.facts), planner.left_after(truth.facts, command))

    def texts_at_hand(self, claim: type[Claim], field: str, moment: Moment[Truth]) -> Sequence[str]:
        """The commands that can be carried out now, their verbs, and the things that they name."""
        commands = self._commands(moment.after)
        if field == "action":
            return commands
        if field == "verb":
            return tuple(dict.fromkeys(map(verb_of, commands)))
        things = dict.fromkeys(filter(None, map(thing_of, commands)))
        return (*things,) if claim is DoAbout else tuple(dict.fromkeys(each.rpartition(" ")[0] for each in things))

    def _commands(self, truth: Truth) -> list[str]:
        """The admissible commands, sorted."""
        engine = self._planner_of(truth).engine
        engine.load(truth.facts)
        return engine.commands()

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        expected = self.lab.action_syntax
        return Task(goal=truth.game.goal), Commands(forms=FORMS), Listed(), Syntax(expected=expected)

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Verdicts on some first commands, a right one among them."""
        commands = self._commands(truth)
        tried = {*self.plan(truth, 1), *(commands[i] for i in rng.integers(len(commands), size=_TRIES).tolist())}
        claims: list[Claim] = []
        for command in sorted(tried):
            gain = self._gain(truth, command)
            if gain is not None:
                claims.append(TriedWell(action=command) if gain > 0 else TriedInVain(action=command))
        return tuple(claims)

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
            planner = self._planner_of(after)
            needed, left = planner.left(before.facts), planner.left(after.facts)
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
        """An admissible command to avoid, another one each turn."""
        commands = self._commands(truth)
        for i in range(len(commands)):
            command = commands[(turn * _STRIDE + i) % len(commands)]
            if self._explores:
                if not self._forward(truth, command):
                    return Needless(action=command)
                continue
            gain = 0 if verb_of(command) in IDLE else self._gain(truth, command)
            if gain is not None and gain <= 0:
                return Avoid(action=command)
        return None

    def _rules(self, truth: Truth) -> tuple[Claim, ...]:
        """In a town, a type of receptacle that never holds the task's object, and the type that always does."""
        thing, law = truth.game.target, dict(truth.game.law)
        if not law:
            return ()
        rules = [AlwaysKept(thing=thing, place=place) for place in keepers()[thing]]
        wrong = [NotAlwaysKept(thing=thing, place=each.place) for each in rules if each.fits(truth) is False]
        return *wrong[:1], *(each for each in rules if each.place == law[thing] and each.fits(truth))

    def importance(self, truth: Truth) -> float:
        """The worst next command's extra cost over the best one, in commands."""
        if truth.won:
            return 0.0
        if self._explores:
            return 0.0 if self._explored(truth) is None else 1.0
        if self._planner_of(truth).left(truth.facts) is None:
            return 0.0
        gains = [self._gain(truth, each) for each in self._commands(truth) if verb_of(each) not in IDLE]
        # Looking around, which is always possible, gains nothing: one command is lost.
        return min(1.0 - min([0, *(gain for gain in gains if gain is not None)]), self.max_importance)

    def idle(self, truth: Truth) -> float:
        """One command."""
        return 1.0

    def regret(self, moment: Moment[Truth]) -> float:
        """Commands wasted by the last one: 0 if it began a shortest plan."""
        if moment.before is None:
            return self.idle(moment.after)
        if moment.before.won:
            return 0.0
        if self._explores:
            return 0.0 if moment.success else float(not self._forward(moment.before, moment.action))
        planner = self._planner_of(moment.after)
        gain = 1 if moment.success else _less(planner.left(moment.before.facts), planner.left(moment.after.facts))
        return 1.0 - gain if gain is not None else 0.0


def _less(before: int | None, after: int | None) -> int | None:
    """The difference of two numbers; None if either is None."""
    return None if before is None or after is None else before - after


_TRIES = 3
_STRIDE = 7
