"""What a personality may look at when it speaks. It sees no template and no family."""

from collections.abc import Callable
from typing import Any

import numpy as np

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, FeedbackType, Moment, R
from teachers.common import Chance, Example, Late, Paid, Right, Trap, Wrong, sign_of
from teachers.fingerprint import Fingerprints
from teachers.oracle import Oracle

HINDSIGHT = frozenset((HP, HN))


class View:
    """The moment, what the oracle knows, and what can be made of a claim.

    A claim that comes late is treated by all methods as what it is: a claim about its own turn.
    """

    def __init__(self, oracle: Oracle, words: Callable[[Claim[Any]], float]) -> None:
        self._oracle = oracle
        self._moments: list[Moment[Any]] = []
        self._fingerprints = Fingerprints()
        self._hindsight: tuple[Claim[Any], ...] | None = None
        self.kinds: frozenset[FeedbackType] = frozenset()
        """The kinds of feedback that are wanted; others are withheld whatever a personality says."""
        self.asked = False
        """Whether the student asks, and advice is all that it wants."""
        self._words = words

    def see(self, moment: Moment[Any], kinds: frozenset[FeedbackType]) -> None:
        """Take note of the next moment, and of the kinds that are wanted now."""
        self._moments.append(moment)
        self.kinds = kinds
        self.asked = False
        self._hindsight = None

    def ask(self) -> None:
        """Take note that the student asks for advice on the moment, once more after all was said."""
        self.asked = True

    @property
    def moment(self) -> Moment[Any]:
        """The moment to speak of."""
        return self._moments[-1]

    @property
    def turn(self) -> int:
        """The number of turns that the student has had."""
        return self.moment.turn

    @property
    def last(self) -> Moment[Any] | None:
        """The moment of the turn before; None at the opening."""
        return self._moments[-2] if len(self._moments) > 1 else None

    # What the oracle knows.

    def values(self) -> tuple[float, ...] | None:
        """Value per discrete action now; None where actions cannot be enumerated."""
        return self._oracle.values(self.moment.after)

    def past_values(self) -> tuple[float, ...] | None:
        """Value per discrete action at the time of the last one; None where no action was executed, too."""
        return None if self.moment.before is None else self._oracle.values(self.moment.before)

    def importance(self) -> float:
        """What is at stake in the next action."""
        return self._oracle.importance(self.moment.after)

    def past_importance(self) -> float:
        """What was at stake in the last action; if none was executed, what still is."""
        moment = self.moment
        return self._oracle.importance(moment.after if moment.before is None else moment.before)

    def plan(self, n: int) -> tuple[Any, ...]:
        """At most `n` actions of an optimal policy from here on."""
        return self._oracle.plan(self.moment.after, n)

    def regret(self) -> float:
        """Value lost by the last action: 0 if it was optimal, ties included."""
        return self._oracle.regret(self.moment)

    def loss(self, action: Any) -> float:
        """Value that the next action would lose if it were this one."""
        return self._oracle.regret(self._tried(self.moment, action))

    def soonest(self, truth: Any, action: Any, horizon: int) -> int | None:
        """After how many actions the task is solved by this one and an optimal policy after it; None if later."""
        moment = Moment.opening(truth)
        for steps in range(1, horizon + 1):
            moment = self._tried(moment, action)
            if moment.success:
                return steps
            plan = self._oracle.plan(moment.after, 1)
            if not plan:
                return None
            action = plan[0]
        return None

    def hindsight(self) -> tuple[Claim[Any], ...]:
        """All hp and hn that is true of the last action, wanted or not."""
        if self._hindsight is None:
            moment = self.moment
            self._hindsight = () if moment.before is None else self._oracle.judge(moment._replace(over=True), HINDSIGHT)
        return self._hindsight

    def right(self) -> bool | None:
        """Whether the last action was good, and nothing about it bad; None if there is nothing to say of it."""
        said = self.hindsight()
        return all(claim.kind is HP for claim in said) if said else None

    def share(self, truth: Any) -> float:
        """A number in [0, 1) that a state has once and for all, spread evenly over the states."""
        return self._fingerprints.share(self._oracle.lab.state_of(truth))

    def fingerprint(self, truth: Any) -> int:
        """A number that is equal for equal states."""
        return self._fingerprints.of(self._oracle.lab.state_of(truth))

    def action_fingerprint(self, action: Any) -> int:
        """A number that is equal for equal actions."""
        return self._fingerprints.of(action)

    # What can be made of a claim.

    def moment_of(self, claim: Claim[Any]) -> Moment[Any]:
        """The moment that a claim is about."""
        return self._moments[claim.turn] if isinstance(claim, Late) else self.moment

    def state_of(self, claim: Claim[Any]) -> Any:
        """The truth in which the action was or will be taken that a claim is about."""
        moment = self.moment_of(claim)
        return moment.after if claim.kind in (FP, FN) or moment.before is None else moment.before

    def words(self, claim: Claim[Any]) -> float:
        """The number of words that saying a claim takes on average, but for those that say that it comes late."""
        return self._words(_bare(claim))

    def holds(self, claim: Claim[Any]) -> bool:
        """Whether a claim is true."""
        return _bare(claim).holds(self.moment_of(claim), self._oracle.lab)

    def distort(self, claim: Claim[Any], rng: np.random.Generator) -> Claim[Any] | None:
        """A claim that is false of the same turn; None if there is no plausible one."""
        false = self._oracle.distort(_bare(claim), self.moment_of(claim), rng)
        return false and _like(claim, false)

    def falsehoods(self, claim: Claim[Any]) -> list[Claim[Any]]:
        """Every plausible claim that is false of the same turn."""
        return [_like(claim, false) for false in self._oracle.falsehoods(_bare(claim), self.moment_of(claim))]

    def flip(self, claim: Claim[Any], rng: np.random.Generator) -> Claim[Any]:
        """The opposite of a verdict: false praise in place of blame, or false blame in place of praise."""
        false = [other for other in self.falsehoods(claim) if other.kind in HINDSIGHT - {claim.kind}]
        if false:
            return false[rng.integers(len(false))]
        opposite = Wrong if claim.kind is HP else Right
        return _like(claim, opposite.on(_bare(claim), action=self.moment_of(claim).action))

    def coarsen(self, claim: Claim[Any], level: int) -> Claim[Any]:
        """What advice or a warning implies, saying less: level 0 is the vaguest, the greatest is the claim itself.

        Where nothing vaguer is known, it is that there is something to do or to avoid. A claim that does not hold
        stays as it is, for it implies nothing.
        """
        bare, moment = _bare(claim), self.moment_of(claim)
        rungs = bare.coarser(moment, self._oracle.lab) or (self._dim(bare),)
        return _like(claim, rungs[level]) if level < len(rungs) and self.holds(claim) else claim

    def vague(self, claim: Claim[Any]) -> Claim[Any]:
        """What is left of a claim without numbers and names. A claim that does not hold stays as it is."""
        bare, moment = _bare(claim), self.moment_of(claim)
        if not self.holds(claim):
            return claim
        if claim.kind is R:
            return _like(claim, Paid(sign=sign_of(moment.reward)))
        if claim.kind in (FP, FN):
            return _like(claim, self._dim(bare))
        return _like(claim, self._verdict(bare, moment))

    def verdict(self) -> Claim[Any] | None:
        """Right or wrong, without a reason; None if there is nothing to say of the last action."""
        said = self.hindsight()
        blame = [claim for claim in said if claim.kind is HN]
        return self._verdict((blame or said)[0], self.moment) if said else None

    def example(self, n: int) -> Example | None:
        """The next actions of an optimal policy, at most `n`, as far as they can be checked; None if none can."""
        lab, moment = self._oracle.lab, self.moment
        ground: list[Claim[Any] | None] = []
        actions: list[Any] = []
        solved = False
        for action in () if moment.over else self.plan(n):
            if solved and np.array_equal(action, actions[-1]):
                break
            now = Moment.opening(moment.after, moment.turn)
            told = self._oracle.judge(now, {FP})
            advised = [c for c in told if isinstance(c, ActionClaim) and np.array_equal(c.action, action)]
            moment = self._tried(moment, action)
            solved = moment.success
            if not solved and not (advised and advised[0].holds(now, lab)):
                break
            actions.append(action)
            ground.append(None if solved else advised[0])
        return Example.on(tuple(ground), actions=tuple(actions)) if actions else None

    def _tried(self, moment: Moment[Any], action: Any) -> Moment[Any]:
        """The moment after another action, in the lab."""
        lab = self._oracle.lab
        lab.restore(moment.after)
        action = lab.legal(action)
        _, reward, _, _, info = lab.advance(action)
        return Moment(moment.after, action, reward, lab.truth, info["success"], moment.turn + 1, False)

    def _dim(self, ground: Claim[Any]) -> Claim[Any]:
        return (Chance if ground.kind is FP else Trap).on(ground)

    def _verdict(self, ground: Claim[Any], moment: Moment[Any]) -> Claim[Any]:
        return (Right if ground.kind is HP else Wrong).on(ground, action=moment.action)


def _bare(claim: Claim[Any]) -> Claim[Any]:
    return claim.claim if isinstance(claim, Late) else claim


def _like(claim: Claim[Any], other: Claim[Any]) -> Claim[Any]:
    """The other claim, late if the first one is."""
    return Late(claim=other, turn=claim.turn) if isinstance(claim, Late) else other
