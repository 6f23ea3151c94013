"""Claims that belong to no family; their phrases are in `phrases/common.toml`."""

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence, Set
from typing import Annotated, Any

import numpy as np

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    FeedbackType,
    Grounded,
    HedgedClaim,
    Moment,
    PlanClaim,
    R,
    Scope,
    Verdict,
    action_of,
    claim,
    opposed,
    unhedged,
)
from worlds.world import World

HORIZON = 100
"""Most actions of a roll-out."""
SIGNS = ("positive", "negative", "zero")
"""The signs of a reward."""


def as_said(number: float) -> str:
    """A reward or value to the precision in which it is said."""
    return f"{number + 0.0:.4g}"


@claim
class Reward(Claim[Any]):
    """True if `reward` is what the world paid for the action of this turn."""

    kind = R
    reward: float

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the world's payment."""
        alike = self.reward == moment.reward or (math.isnan(self.reward) and math.isnan(moment.reward))
        return moment.before is not None and alike

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Compare with the world's payment."""
        return moment.before is not None and as_said(self.reward) == as_said(moment.reward)

    def excludes(self, other: Claim[Any]) -> bool:
        """Another reward, or its sign."""
        if isinstance(other, Paid):
            return other.sign != sign_of(self.reward)
        return isinstance(other, Reward) and other.reward != self.reward

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """Another reward that the world might pay."""
        low, high = lab.reward_range
        others = (1.0 - self.reward, 0.5 * self.reward, low, high)
        return tuple(Reward(reward=r) for r in others if low <= r <= high and r != self.reward)[:1]


class _Outcome(Verdict[Any]):
    """Whether the task is solved."""

    __slots__ = ()

    def applies(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Any action, also a text that is none."""
        return moment.action is not None

    def good(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Look up the success of the moment."""
        return moment.success


@claim
class TryAgain(_Outcome):
    """True if the task is not solved."""

    kind = HN


@claim
class Solved(_Outcome):
    """True if the task is solved."""

    kind = HP


opposed(Solved, TryAgain)


@claim
class Truism(Claim[Any]):
    """True always: a fact that has nothing to do with the task, from the list of the placebo personality."""

    kind: FeedbackType | None  # type: ignore[misc]  # other claims are filed by their class
    """The kind of the claim that it stands in for: a truism has none of its own."""
    placebo = True
    fact: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Look the fact up."""
        return self.fact in FACTS

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """A fact turned into its opposite."""
        return (Truism(kind=self.kind, fact=f"it is wrong that {self.fact}"),)


class _Judged(Grounded[Any], ActionClaim[Any]):
    """A verdict without a reason, on the action of this turn; its ground is all hindsight on that, with reasons.

    Hindsight that is `relative` is no verdict, and does not count.
    """

    __slots__ = ()
    action_slot = ""

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the ground: blame that does not hold counts as praise, and praise that does not hold as blame."""
        ground = (each for each in self._ground if not each.relative)
        kinds = {HP if (each.kind is HP) == each.holds(moment, lab) else HN for each in ground}
        return _acted(self.action, moment) and self._fits(kinds)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Judge the action."""
        hindsight = oracle.judge(moment._replace(over=True), {HP, HN})
        kinds = {each.kind for each in hindsight if not each.relative}
        return _acted(self.action, moment) and self._fits(kinds)

    @staticmethod
    @abstractmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        """Whether this is the verdict where hindsight is of these kinds."""


@claim
class Right(_Judged):
    """True if all hindsight on the action of this turn, of which there is some, is praise."""

    kind = HP
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return kinds == {HP}

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The opposite verdict."""
        return (Wrong.on(self._ground, action=self.action),)

    def excludes(self, other: Claim[Any]) -> bool:
        """All blame."""
        return other.kind is HN and not other.placebo


@claim
class PartlyRight(_Judged):
    """True if hindsight on the action of this turn is praise and blame."""

    kind = HP
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return kinds == {HP, HN}

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """That all of it was right."""
        return (Right.on(self._ground, action=self.action),)

    def excludes(self, other: Claim[Any]) -> bool:
        """That all of it was right."""
        return isinstance(other, Right)


@claim
class Wrong(_Judged):
    """True if some hindsight on the action of this turn is blame: something was wrong with it."""

    kind = HN
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return HN in kinds

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The opposite verdict."""
        return (Right.on(self._ground, action=self.action),)


@claim
class NoDifference(Grounded[Any], ActionClaim[Any]):
    """True if the best other action is worth as much as the action of this turn, to within `margin`.

    Its ground is the verdict on the action, which is praise if no other action is worth more.
    """

    kind = HP
    action_slot = ""
    action: Any
    mine: float
    """Value of the action."""
    other: float
    """Greatest value of another action."""
    margin: float

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the verdict, that the values agree with it, and that it comes to the same values."""
        praised = (self._ground.kind is HP) == self.stands(moment, lab)
        return (
            _acted(self.action, moment)
            and abs(self.mine - self.other) < self.margin
            and praised == (self.mine >= self.other)
            and self._agrees(moment, lab)
        )

    def excludes(self, other: Claim[Any]) -> bool:
        """Blame of the action."""
        return other.kind is HN and isinstance(other, ActionClaim) and bool(other.action == self.action)

    def _agrees(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Whether the values are what the verdict finds for each action, if it can tell."""
        actions = [lab.legal(each) for each in range(int(lab.action_space.n))]  # type: ignore[attr-defined]  # Discrete
        values = {action: self._ground.stated_worth(moment, lab, action) for action in actions}
        if None in values.values():
            return True
        mine = values.pop(self.action)
        return bool(np.allclose((self.mine, self.other), (mine, max(values.values())), rtol=1e-9, atol=1e-9))

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The opposite of the ground."""
        cls = Wrong if self.mine >= self.other else Right
        return (cls.on((self._ground,), action=self.action),)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Compute the values."""
        values = None if moment.before is None else oracle.stated_values(moment.before)
        if values is None or not _acted(self.action, moment):
            return False
        other = max(value for action, value in enumerate(values) if action != moment.action)
        alike = as_said(self.mine) == as_said(values[moment.action]) and as_said(self.other) == as_said(other)
        return alike and bool(abs(values[moment.action] - other) < self.margin)


@claim
class Better(Grounded[Any]):
    """True if `this` is worth more as the next action than `that`; its ground is a verdict on `this`, once it is tried.

    Where actions have no values, it is true if after `this` the task is solved in fewer actions than after `that`, each
    followed by the plan; then its ground has both ways, which are rolled out with the same draws. It says of neither
    action whether it is good.
    """

    kind = FP
    this: Any
    """An action in the form that `World.step` takes, as the other one."""
    that: Any

    @property
    def first(self) -> str:
        """The better action as a student writes it."""
        return _written(self.this)

    @property
    def second(self) -> str:
        """The other one."""
        return _written(self.that)

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Try the action, and ask the verdict what both are worth; or go both ways."""
        if moment.over:
            return False
        if isinstance(self._ground, tuple):
            begun = all(way[:1] in ((), (own,)) for own, way in zip((self.this, self.that), self._ground, strict=True))
            this, that = (_steps(way, moment.after, lab) for way in self._ground)
            return begun and this < that
        lab.restore(moment.after)
        _, reward, _, _, info = lab.advance(lab.legal(self.this))
        tried = Moment(moment.after, self.this, reward, lab.truth, info["success"], moment.turn + 1, False)
        worths = [self._ground.worth(tried, lab, action) for action in (self.this, self.that)]
        return None not in worths and worths[0] - worths[1] > _EQUAL

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Compare the values, or the numbers of actions until the task is solved."""
        if moment.over:
            return False
        if (values := oracle.values(moment.after)) is not None:
            return bool(values[self.this] - values[self.that] > _EQUAL)
        this, that = (len(oracle.way(moment.after, each, HORIZON)) or math.inf for each in (self.this, self.that))
        return this < that

    def excludes(self, other: Claim[Any]) -> bool:
        """The reverse, and advice to take the worse action."""
        if isinstance(other, Better):
            return (other.this, other.that) == (self.that, self.this)
        return other.kind is FP and action_of(other) is not None and bool(action_of(other) == self.that)

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The reverse."""
        ground = self._ground[::-1] if isinstance(self._ground, tuple) else self._ground
        return (Better.on(ground, this=self.that, that=self.this),)


@claim
class _Turns(Grounded[Any]):
    """Base of comparisons of the action of this turn with that of an earlier one, by what each loses.

    The ground has the moment of the earlier turn, and a verdict on each, on that of this turn first.
    """

    ago: int
    """How many turns earlier."""

    @property
    def earlier(self) -> str:
        """The earlier turn in words."""
        return "the turn before" if self.ago == 1 else f"{self.ago} turns earlier"

    def _fits(self, lost: float, earlier: float) -> bool:
        """Whether this is so where the actions lose as much."""
        gain = earlier - lost if self.kind is HP else lost - earlier
        return gain > _EQUAL

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Ask the verdicts what each action of both turns is worth."""
        earlier, *verdicts = self._ground
        if earlier is None or moment.before is None or earlier.turn != moment.turn - self.ago:
            return False
        lost = [_lost(verdict, each, lab) for verdict, each in zip(verdicts, (moment, earlier), strict=True)]
        return None not in lost and self._fits(*lost)  # type: ignore[arg-type]  # no None

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Compare the regrets."""
        earlier, *_ = self._ground
        known = earlier is not None and earlier.before is not None and moment.before is not None
        return known and self._fits(oracle.regret(moment), oracle.regret(earlier))

    def within(self, moments: Callable[[int], Moment[Any]], about: int) -> "_Turns":
        """The same with the earlier turn there."""
        earlier = moments(about - self.ago) if about > self.ago else None
        return self.on((earlier, *self._ground[1:]), ago=self.ago)

    def excludes(self, other: Claim[Any]) -> bool:
        """The opposite."""
        return isinstance(other, _Turns) and other.kind is not self.kind and other.ago == self.ago

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The opposite."""
        return ((WorseTurn if self.kind is HP else BetterTurn).on(self._ground, ago=self.ago),)


@claim
class BetterTurn(_Turns):
    """True if the action of this turn lost less than that of the turn `ago` turns earlier."""

    kind = HP


@claim
class WorseTurn(_Turns):
    """True if the action of this turn lost more than that of the turn `ago` turns earlier."""

    kind = HN


@claim
class Paid(Claim[Any]):
    """True if the reward for the action of this turn is so: `positive`, `negative` or `zero`."""

    kind = R
    sign: Annotated[str, SIGNS]

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the world's payment."""
        return moment.before is not None and self.sign == sign_of(moment.reward)

    def excludes(self, other: Claim[Any]) -> bool:
        """Another sign."""
        return isinstance(other, Paid) and other.sign != self.sign

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The other signs that a reward of the world can have."""
        low, high = lab.reward_range
        signs = {"positive": high > 0, "negative": low < 0, "zero": low <= 0 <= high}
        return tuple(Paid(sign=sign) for sign, possible in signs.items() if possible and sign != self.sign)


@claim
class Chance(Grounded[Any]):
    """True if there is something good to do next: its ground, an advice, holds."""

    kind = FP

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the advice."""
        return not self._ground.relative and self.stands(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask for advice."""
        return any(each.kind is FP and not each.relative for each in oracle.judge(moment, {FP}))


@claim
class Trap(Grounded[Any]):
    """True if there is something to avoid next: its ground, a warning, holds."""

    kind = FN

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the warning."""
        return not self._ground.relative and self.stands(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask for warnings."""
        return any(each.kind is FN and not each.relative for each in oracle.judge(moment, {FN}))


@claim
class Example(Grounded[Any], PlanClaim[Any]):
    """True if these actions are optimal one after the other: its ground has for each the advice to take it, which holds
    at that point, or None if it solves the task.
    """  # noqa: D205

    kind = FP
    plan_slot = "steps"
    separator = ", then "
    actions: tuple[Any, ...]

    @property
    def action(self) -> Any:
        """The first of them."""
        return self.actions[0]

    @property
    def steps(self) -> str:
        """The actions as a student writes them."""
        return self.separator.join(map(_written, self.actions))

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Take the actions, and check the advice on the way."""
        truth = moment.after
        for action, advice in zip(self.actions, self._ground, strict=True):
            if advice is not None and not advice.holds(moment._replace(after=truth), lab):
                return False
            lab.restore(truth)
            solved = lab.step(action)[4]["success"]
            if advice is None and not solved:
                return False
            truth = lab.truth
        return True

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Take the actions; each is advised where it is taken, or solves the task."""
        for action in self.actions:
            now = Moment.opening(moment.after, moment.turn)
            advice = oracle.judge(now, {FP})
            moment = oracle.try_out(moment, action)
            if not (moment.success or any(action_of(each) == action for each in advice)):
                return False
        return True

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """Begin with another action."""
        first, *rest = self._ground
        if first is None:
            rng = np.random.default_rng(0)
            others: list[tuple[Any, Any]] = [(None, lab.legal(lab.sample_action(rng))) for _ in range(_TRIES)]
        else:
            others = [(c, c.action) for c in first.counterparts(moment, lab) if isinstance(c, ActionClaim)]
        return tuple(Example.on((advice, *rest), actions=(action, *self.actions[1:])) for advice, action in others)


@claim
class NotUnderstood(Claim[Any]):
    """True if the student's text was no action, and `expected` is what the world understands; `why` says what is wrong.

    A notice of the environment, not feedback of the teacher: no personality and no feedback type withholds it.
    """

    scope = Scope.ACTION
    got: str
    expected: str
    why: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the turn's parse failure."""
        return moment.action == (self.got, self.expected, self.why) and self.expected == lab.action_syntax


@claim
class MayAsk(Claim[Any]):
    """True if the student may ask for advice in place of acting, once a turn, and pays `cost` for it."""

    scope = Scope.STATE  # that is the only moment with the price
    cost: float

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the price in the opening moment."""
        return moment.ask_cost == self.cost


@claim
class Maximize(Claim[Any]):
    """True of every world, if nothing but its rewards counts: how reinforcement learning is put as an instruction."""

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """By definition."""
        return True


@claim
class Syntax(Claim[Any]):
    """True if `expected` is what the world understands as an action."""

    expected: str

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the syntax that the world states; it must take actions of its own, and refuse what is none."""
        lab.restore(moment.after)
        rng = np.random.default_rng(moment.turn)
        drawn = [lab.sample_action(rng) for _ in range(_TRIES)]
        return self.expected == lab.action_syntax and all(_is_legal(a, lab) for a in drawn) and not _is_legal(..., lab)


@claim
class Late(Claim[Any]):
    """A claim about an earlier turn: true if `claim` was true at that turn.

    It is passed from a personality to the voice only; the atom holds the claim itself and its turn.
    """

    claim: Claim[Any]
    turn: int

    @property
    def kind(self) -> FeedbackType | None:  # type: ignore[override]  # that of the claim
        """The kind of the claim that comes late."""
        return self.claim.kind


@claim
class Probably(HedgedClaim[Any]):
    """Neither true nor false: it says that `claim` is true with the probability `p`.

    The probability is rounded as it is said, to whole per cent from 51 to 99, since a hedge is never flat.

    Raises:
        ValueError: the probability is not above 0.5 and below 1, or the claim is late or hedged itself.
    """

    claim: Claim[Any]
    p: float

    def __post_init__(self) -> None:
        if not 0.5 < self.p < 1:
            raise ValueError(f"p must be above 0.5 and below 1, got {self.p!r}; hedge what is more probable than not")
        if isinstance(self.claim, HedgedClaim | Late):
            raise ValueError(
                f"a hedge needs a flat claim that is not late, got {self.claim!r}; "
                "hedge the claim itself, by `hedge(claim, p)`, which keeps its turn"
            )
        object.__setattr__(self, "p", min(max(round(float(self.p), 2), 0.51), 0.99))

    @property
    def kind(self) -> FeedbackType | None:  # type: ignore[override]  # that of the claim
        """The kind of what is hedged."""
        return self.claim.kind

    @property
    def percent(self) -> int:
        """The probability in per cent."""
        return round(100 * self.p)

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Whether what is hedged holds, by which hedges are judged together."""
        return self.claim.holds(moment, lab)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Whether what is hedged is true by its fields."""
        return self.claim.means(moment, oracle)

    def excludes(self, other: Claim[Any]) -> bool:
        """What it hedges excludes: of two such claims only one can be probable."""
        other = unhedged(other)
        return self.claim.excludes(other) or other.excludes(self.claim)

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """Those of what it hedges, with the same probability."""
        return tuple(Probably(claim=each, p=self.p) for each in self.claim.counterparts(moment, lab))


def hedge(claim: Claim[Any], p: float) -> Claim[Any]:
    """Say a claim with a probability in place of flatly, or with another one if it is hedged; what is late stays late.

    Raises:
        ValueError: the probability is not above 0.5 and below 1.
    """
    if isinstance(claim, Late):
        return Late(claim=hedge(claim.claim, p), turn=claim.turn)
    return Probably(claim=unhedged(claim), p=p)


def bend(claim: Claim[Any], factor: float) -> Claim[Any]:
    """A hedged claim with its log-odds multiplied by a factor above 0; any other claim as it is.

    A hedge stays one: its probability is again rounded to whole per cent, from 51 to 99.
    """
    bare = claim.claim if isinstance(claim, Late) else claim
    if not isinstance(bare, HedgedClaim):
        return claim
    yes, no = bare.p**factor, (1 - bare.p) ** factor
    return hedge(claim, min(max(yes / (yes + no), 0.51), 0.99))


def sign_of(reward: float) -> str:
    """Whether a reward is `positive`, `negative` or `zero`."""
    return "positive" if reward > 0 else "negative" if reward < 0 else "zero"


def _written(action: Any) -> str:
    """An action as a student writes it."""
    return f'"{action}"' if isinstance(action, str) else f"{action}"


def _steps(way: Sequence[Any], truth: Any, lab: World[Any]) -> float:
    """Number of actions until the task is solved, with the same draws each time; infinite if it is not."""
    lab.restore(truth)
    lab.np_random = np.random.default_rng(0)
    return next((n for n, each in enumerate(way, 1) if lab.advance(lab.legal(each))[4]["success"]), math.inf)


def _lost(verdict: Claim[Any], moment: Moment[Any], lab: World[Any]) -> float | None:
    """What the action of a moment loses, by what a verdict on it finds all actions worth; None if it cannot tell."""
    worths = [
        verdict.worth(moment, lab, lab.legal(each))
        for each in range(int(lab.action_space.n))  # type: ignore[attr-defined]  # Discrete
    ]
    known = [worth for worth in worths if worth is not None]
    return max(known) - known[moment.action] if len(known) == len(worths) else None


def _is_legal(action: Any, lab: World[Any]) -> bool:
    try:
        lab.legal(action)
    except ValueError:
        return False
    return True


def _acted(action: Any, moment: Moment[Any]) -> bool:
    return moment.before is not None and np.array_equal(action, moment.action)


_TRIES = 5
_EQUAL = 1e-9  # values that differ by less differ by rounding
FACTS = (
    "ice melts",
    "rain falls",
    "fire burns",
    "time passes",
    "ice is cold",
    "a week has seven days",
    "the sun rises in the east",
    "bread is often made from wheat flour",
    "a triangle has three sides and three corners",
    "most cats sleep for many hours of the day",
    "letters are sorted into the alphabet from a to z",
    "a bicycle has two wheels and a car usually has four",
    "rain falls from clouds and rivers carry the water to the sea",
    "the moon goes around the earth about once in every twenty-seven days",
    "an orchestra has strings, woodwinds, brass and percussion, and a conductor who leads them",
    "paper is made from wood, and wood comes from trees, which need light and water to grow",
)
"""True, useless sentences of 2 to 17 words, by length."""
