"""The bandits' oracle: it judges arms by what they pay on average."""

import math
from collections.abc import Sequence, Set
from functools import cache
from itertools import combinations, islice
from typing import Annotated, Any

import numpy as np
from typing_extensions import override

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    FeedbackType,
    HintClaim,
    Moment,
    Scope,
    Verdict,
    claim,
    opposed,
)
from teachers.oracle import Oracle
from teachers.rules import TownRule
from teachers.spec import Range
from teachers.words import listed
from worlds.actions import is_element
from worlds.bandits import FEATURES, Bandit, Law, Truth

Look = Annotated[str, tuple(word for words in FEATURES for word in words)]
"""A word of `worlds.bandits.FEATURES`."""


@claim
class Goal(Claim[Truth, Bandit]):
    """True if this is how many arms there are."""

    arms: int

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Offer the world the last arm, and one more."""
        return is_element(lab.action_space, self.arms - 1) and not is_element(lab.action_space, self.arms)


@claim
class Random(Claim[Truth, Bandit]):
    """True if chance decides what some arm pays."""

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull each arm once: where chance decides, none pays just what it pays on average."""
        return not _is_steady(moment.after, lab)


@claim
class Steady(Claim[Truth, Bandit]):
    """True if each arm pays the same whenever it is pulled."""

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull each arm once: it pays just what it pays on average."""
        return _is_steady(moment.after, lab)


@claim
class Answer(Claim[Truth, Bandit]):
    """True if the numbers from 0 to `last` are the arms."""

    last: int

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Offer the world this number and the next."""
        return is_element(lab.action_space, self.last) and not is_element(lab.action_space, self.last + 1)


@claim
class _Tried(Verdict[Truth, Bandit], ActionClaim[Truth, Bandit]):
    """Base of verdicts on an arm that the oracle tried."""

    tried = True
    action: int
    mean: float

    def applies(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Multiply the arm's chance and payout."""
        return abs(_expected(moment.after, self.action) - self.mean) <= 5.1e-4

    def good(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Multiply chance and payout of each arm."""
        return _is_best(moment.after, self.action)


@claim
class TriedBest(_Tried):
    """True if no arm pays more on average than `action`, which pays `mean` on average (to 3 decimals)."""

    kind = HP


@claim
class TriedPoor(_Tried):
    """True if some arm pays more on average than `action`, which pays `mean` on average (to 3 decimals)."""

    kind = HN


opposed(TriedBest, TriedPoor)


@claim
class Solution(ActionClaim[Truth, Bandit]):
    """True if no arm pays more on average than `action`."""

    action: int

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull it and ask whether that was a success."""
        return _succeeds(moment.after, self.action, lab)


@claim
class _Pulled(Verdict[Truth, Bandit], ActionClaim[Truth, Bandit]):
    """Base of verdicts on the arm that was pulled."""

    action: int

    def applies(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Look the action up."""
        return moment.before is not None and moment.action == self.action

    def good(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Multiply chance and payout of each arm."""
        return _is_best(moment.past, self.action)

    def worth(self, moment: Moment[Truth], lab: Bandit, action: int) -> float:
        """Multiply chance and payout of the arm."""
        return _expected(moment.past, action)


@claim
class PulledBest(_Pulled):
    """True if the arm that was pulled is a best one; tied arms are all best."""

    kind = HP


@claim
class PulledPoor(_Pulled):
    """True if some arm pays more on average than the one that was pulled."""

    kind = HN


opposed(PulledBest, PulledPoor)


@claim
class Pull(ActionClaim[Truth, Bandit]):
    """True if no arm pays more on average than `action`."""

    kind = FP
    action: int
    counterparts = Claim.varied("action", lambda _, __, lab: range(lab.arms))

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull it and ask whether that was a success."""
        return _succeeds(moment.after, self.action, lab)

    def coarser(self, moment: Moment[Truth], lab: Bandit) -> Sequence[Claim]:
        """Half of the arms, then a pair; only sets smaller than all arms."""
        arms = lab.arms
        sizes = [size for size in (arms // 2, 2) if 2 <= size < arms]
        return tuple(_among(self.action - self.action % size, size, arms) for size in dict.fromkeys(sizes))


@claim
class Among(HintClaim[Truth, Bandit]):
    """True if one of the arms from `low` to `high` is a best one."""

    kind = FP
    scope = Scope.WORLD
    low: int
    high: int

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull them all and ask whether that was a success."""
        return any(_succeeds(moment.after, arm, lab) for arm in range(self.low, self.high + 1))

    @override
    def leaves(self, action: int) -> bool:
        return self.low <= action <= self.high

    @override
    def excludes(self, other: Claim) -> bool:
        """A warning of one of the arms; of a pair, also blame of one, since the other is the answer then."""
        blamed = other.kind is HN and isinstance(other, ActionClaim) and self.leaves(other.action)
        return HintClaim.excludes(self, other) or (blamed and self.high - self.low == 1)

    def counterparts(self, moment: Moment[Truth], lab: Bandit) -> Sequence[Claim]:
        """As many other arms."""
        size, arms = self.high - self.low + 1, lab.arms
        return tuple(_among(low, size, arms) for low in range(0, arms - 1, size) if low != self.low)


@claim
class Avoid(ActionClaim[Truth, Bandit]):
    """True if some arm pays more on average than `action`."""

    kind = FN
    action: int
    counterparts = Claim.varied("action", lambda _, __, lab: range(lab.arms))

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull it and ask whether that was a success."""
        return not _succeeds(moment.after, self.action, lab)


@claim
class OneOf(Claim[Truth, Bandit]):
    """True if one of these arms is a best one."""

    kind = FP
    scope = Scope.WORLD
    arms: tuple[Annotated[int, Range(0, 999)], ...]
    listing = property(lambda claim: listed(claim.arms))

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Pull them all and ask whether that was a success."""
        return any(_succeeds(moment.after, arm, lab) for arm in self.arms if arm < lab.arms)

    def counterparts(self, moment: Moment[Truth], lab: Bandit) -> Sequence[Claim]:
        """As many other arms, if there are enough."""
        others = tuple(islice((arm for arm in range(lab.arms) if arm not in self.arms), len(self.arms)))
        return (OneOf(arms=others),) if len(others) == len(self.arms) else ()

    def excludes(self, other: Claim) -> bool:
        """None of these arms; where arms are tied, both may hold."""
        return isinstance(other, OneOf) and not set(self.arms) & set(other.arms)


@claim
class NoMoreThan(Claim[Truth, Bandit]):
    """True if no arm pays more than `most` on average."""

    kind = FN
    scope = Scope.WORLD
    most: float
    counterparts = Claim.varied("most", lambda claim, _, __: [round(claim.most - less, 1) for less in (0.1, 0.3, 0.5)])

    def holds(self, moment: Moment[Truth], lab: Bandit) -> bool:
        """Multiply chance and payout of each arm."""
        return max(_expected(moment.after, arm) for arm in range(lab.arms)) <= self.most


@claim
class _Ranked(TownRule[Truth, Bandit]):
    """Base of rules that compare arms by their looks."""

    looks: Look
    others: tuple[Look, ...]
    """Other words of the same feature."""
    listing = property(lambda claim: " or ".join(claim.others))

    def fits(self, truth: Truth) -> bool | None:
        """Compare the mean rewards of arms with these looks and of the others."""
        own, others = [], []
        for arm, row in enumerate(truth.looks):
            words = {each[i] for each, i in zip(FEATURES, row, strict=True)}
            if self.looks in words:
                own.append(_expected(truth, arm))
            elif not words.isdisjoint(self.others):
                others.append(_expected(truth, arm))
        return self._orders(own, others) if own and others else None

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Compare the weights of the words in the law."""
        law = moment.after.law
        weights = {word: law[i][j] for i, words in enumerate(FEATURES) for j, word in enumerate(words)} if law else {}
        return bool(law) and self._orders([weights[self.looks]], [weights[word] for word in self.others])

    def _orders(self, own: Sequence[float], others: Sequence[float]) -> bool:
        """Whether all `own` values are on the right side of all `others`."""
        low, high = (others, own) if self.kind is FP else (own, others)
        return max(low) < min(high)

    def counterparts(self, moment: Moment[Truth], lab: Bandit) -> Sequence[Claim]:
        """As many other words."""
        size = len(self.others)
        rules = (
            type(self)(looks=looks, others=others)
            for words in FEATURES
            for looks in words
            for others in combinations([word for word in words if word != looks], size)
        )
        return tuple(rule for rule in rules if rule != self)

    def excludes(self, other: Claim) -> bool:
        """Rules that order two words otherwise, or use the other feature."""
        if not isinstance(other, _Ranked):
            return False
        (mine, its), features = (each._pairs() for each in (self, other)), [set(words) for words in FEATURES]
        same = any({self.looks, other.looks} <= words for words in features)
        return not same or any((low, high) in its for high, low in mine)

    def _pairs(self) -> set[tuple[str, str]]:
        """Pairs of words; arms of the first word pay more."""
        return {(self.looks, word) if self.kind is FP else (word, self.looks) for word in self.others}


@claim
class PayMore(_Ranked):
    """True if in the town arms of these looks pay more on average than each arm of the others."""

    kind = FP


@claim
class PayLess(_Ranked):
    """True if in the town arms of these looks pay less on average than each arm of the others."""

    kind = FN


def _rules(law: Law) -> tuple[Claim, ...]:
    """Rules of a town: looks of arms that pay less than others, and looks of arms that pay most."""
    for words, weights in zip(FEATURES, law, strict=False):
        if any(weights):
            low, *middle, high = sorted(words, key=lambda word: weights[words.index(word)])
            return PayLess(looks=low, others=tuple(middle)), PayMore(looks=high, others=(low, *middle))
    return ()


def _among(low: int, size: int, arms: int) -> Among:
    low = min(low, arms - size)
    return Among(low=low, high=low + size - 1)


def _succeeds(truth: Truth, arm: int, lab: Bandit) -> bool:
    lab.restore(truth)
    return bool(lab.step(arm)[4]["success"])


def _is_steady(truth: Truth, lab: Bandit) -> bool:
    lab.restore(truth)
    return all(lab.step(arm)[1] == _expected(truth, arm) for arm in range(len(truth.chances)))


def _expected(truth: Truth, arm: int) -> float:
    return truth.chances[arm] * truth.payouts[arm]


def _is_best(truth: Truth, arm: int) -> bool:
    return all(_expected(truth, arm) >= _expected(truth, other) for other in range(len(truth.chances)))


@cache
def _of_arm(cls: type[_Pulled | Avoid], arm: int) -> Claim:
    """A claim of a class about an arm; there are few, so that each is made once."""
    return cls(action=arm)


_TRIES = 2
_FEW = 3
_STEPS = 20  # of what no arm exceeds, in each unit


class BanditOracle(Oracle[Truth, Bandit]):
    """Judges pulls by the arm's expected reward, which is also its value."""

    max_importance = 200.0

    def start(self, truth: Truth) -> None:
        """Sort the arms into best and poor ones."""
        self._best = truth.best
        self._poor = tuple(arm for arm in range(len(truth.means)) if arm not in self._best)
        self._pull = Pull(action=self._best[0])

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        arms = len(truth.means)
        chancy = truth.spread > 0 or any(0 < chance < 1 for chance in truth.chances)
        return Goal(arms=arms), Random() if chancy else Steady(), Answer(last=arms - 1)

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """At most two poor arms with their mean rewards."""
        tries = rng.permutation(self._poor)[:_TRIES].tolist()
        return tuple(TriedPoor(action=arm, mean=round(truth.means[arm], 3)) for arm in tries)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        return (Solution(action=self._best[0]),)

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        verdict = _of_arm(PulledBest if moment.action in self._best else PulledPoor, moment.action)
        if verdict.kind in kinds:
            claims.append(verdict)

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        if FP in kinds:
            claims.append(self._pull)
        if FN in kinds and self._poor:
            claims.append(_of_arm(Avoid, self._poor[moment.turn % len(self._poor)]))

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """The better half of the arms, a bound of mean rewards, rules of a town, and three arms with the best."""
        arms = len(truth.means)
        ranked = sorted(range(arms), key=lambda arm: -truth.means[arm])
        most = math.ceil(_STEPS * max(truth.means)) / _STEPS
        sizes = [size for size in dict.fromkeys((arms // 2, _FEW)) if 1 < size <= arms // 2]
        better = [OneOf(arms=tuple(sorted(ranked[:size]))) for size in sizes]
        told = self.lab.problem.fixed or (truth.spread == 0 and most >= 1)  # a student knows it without words
        rules = _rules(truth.law)
        return *better[:1], *rules[:1], *(() if told else (NoMoreThan(most=most),)), *rules[1:], *better[1:]

    def values(self, truth: Truth) -> tuple[float, ...]:
        """Expected reward per arm."""
        return truth.means

    def idle(self, truth: Truth) -> float:
        """The best expected reward minus that of a turn without a pull: 0, or the worst arm's if lower."""
        return max(truth.means) - min(0.0, *truth.means)

    def importance(self, truth: Truth) -> float:
        """Best expected reward minus the worst."""
        return max(truth.means) - min(truth.means)

    def plan(self, truth: Truth, n: int) -> tuple[int, ...]:
        """A best arm, again and again."""
        return (truth.best[0],) * n
