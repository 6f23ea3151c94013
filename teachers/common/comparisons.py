"""Comparisons of actions and of turns."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from teachers.atoms import FP, HN, HP, ActionClaim, Claim, Grounded, Moment, action_of, claim
from teachers.common.advice import as_written
from teachers.common.rewards import as_said
from teachers.common.verdicts import Right, Wrong, acted
from worlds.world import World

HORIZON = 100
"""Most actions of a roll-out."""
_EQUAL = 1e-9  # values that differ by less differ by rounding


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
        """Check the verdict, that the values agree with it, and that it finds the same values."""
        praised = (self._ground.kind is HP) == self.stands(moment, lab)
        return (
            acted(self.action, moment)
            and abs(self.mine - self.other) < self.margin
            and praised == (self.mine >= self.other)
            and self._agrees(moment, lab)
        )

    def excludes(self, other: Claim[Any]) -> bool:
        """Any blame of the action."""
        return other.kind is HN and isinstance(other, ActionClaim) and bool(other.action == self.action)

    def _agrees(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Whether the verdict finds the same values, or cannot tell."""
        actions = [lab.legal(each) for each in range(int(lab.action_space.n))]  # type: ignore[attr-defined]  # Discrete
        values = {action: self._ground.stated_worth(moment, lab, action) for action in actions}
        if None in values.values():
            return True
        mine = values.pop(self.action)
        return bool(np.allclose((self.mine, self.other), (mine, max(values.values())), rtol=1e-9, atol=1e-9))

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """A verdict opposite to the ground."""
        cls = Wrong if self.mine >= self.other else Right
        return (cls.on((self._ground,), action=self.action),)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask the oracle for the values."""
        values = None if moment.before is None else oracle.stated_values(moment.before)
        if values is None or not acted(self.action, moment):
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
    """An action in the form that `World.step` takes; so is `that`."""
    that: Any

    @property
    def first(self) -> str:
        """The better action as a student writes it."""
        return as_written(self.this)

    @property
    def second(self) -> str:
        """The worse action as a student writes it."""
        return as_written(self.that)

    def gain(self) -> float:
        """How many actions sooner the better action solves the task; infinite if actions have values."""
        if not isinstance(self._ground, tuple):
            return math.inf
        this, that = (len(way) or math.inf for way in self._ground)
        return that - this

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Try the action and ask the verdict for the values of both, or roll both ways out."""
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
        pair = [oracle.lab.legal(each) for each in (self.this, self.that)]  # else -1 would be the last action
        if (values := oracle.values(moment.after)) is not None:
            return bool(values[pair[0]] - values[pair[1]] > _EQUAL)
        this, that = (len(oracle.way(moment.after, each, HORIZON)) or math.inf for each in pair)
        return this < that

    def excludes(self, other: Claim[Any]) -> bool:
        """The reverse comparison, and advice to take the worse action."""
        if isinstance(other, Better):
            return (other.this, other.that) == (self.that, self.this)
        return other.kind is FP and action_of(other) is not None and bool(action_of(other) == self.that)

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The reverse comparison."""
        ground = self._ground[::-1] if isinstance(self._ground, tuple) else self._ground
        return (Better.on(ground, this=self.that, that=self.this),)


@claim
class _Turns(Grounded[Any]):
    """Base of comparisons of this turn's action with an earlier turn's, by the value that each loses.

    The ground is the moment of the earlier turn, a verdict on this turn, and a verdict on the earlier one.
    """

    ago: int
    """How many turns earlier."""

    @property
    def earlier(self) -> str:
        """The earlier turn, in words."""
        return "the turn before" if self.ago == 1 else f"{self.ago} turns earlier"

    def _fits(self, lost: float, earlier: float) -> bool:
        """Whether the comparison holds if this turn's action loses `lost` and the earlier one `earlier`."""
        gain = earlier - lost if self.kind is HP else lost - earlier
        return gain > _EQUAL

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Ask both verdicts for the values of all actions."""
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
        """The same comparison, grounded on the earlier turn of this episode."""
        earlier = moments(about - self.ago) if about > self.ago else None
        return self.on((earlier, *self._ground[1:]), ago=self.ago)

    def excludes(self, other: Claim[Any]) -> bool:
        """The opposite comparison."""
        return isinstance(other, _Turns) and other.kind is not self.kind and other.ago == self.ago

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The opposite comparison."""
        return ((WorseTurn if self.kind is HP else BetterTurn).on(self._ground, ago=self.ago),)


@claim
class BetterTurn(_Turns):
    """True if the action of this turn lost less than that of the turn `ago` turns earlier."""

    kind = HP


@claim
class WorseTurn(_Turns):
    """True if the action of this turn lost more than that of the turn `ago` turns earlier."""

    kind = HN


def _steps(way: Sequence[Any], truth: Any, lab: World[Any]) -> float:
    """Number of actions until the task is solved, infinite if they do not solve it; draws are the same each time."""
    lab.restore(truth)
    lab.np_random = np.random.default_rng(0)
    return next((n for n, each in enumerate(way, 1) if lab.advance(lab.legal(each))[4]["success"]), math.inf)


def _lost(verdict: Claim[Any], moment: Moment[Any], lab: World[Any]) -> float | None:
    """The value that the action of a moment loses, by a verdict on it; None if the verdict cannot tell."""
    worths = [
        verdict.worth(moment, lab, lab.legal(each))
        for each in range(int(lab.action_space.n))  # type: ignore[attr-defined]  # Discrete
    ]
    known = [worth for worth in worths if worth is not None]
    return max(known) - known[moment.action] if len(known) == len(worths) else None
