"""Verdicts that belong to no family, and a base for verdicts on what an action changed."""

from abc import abstractmethod
from collections.abc import Sequence, Set
from typing import Any

import numpy as np
from typing_extensions import override

from teachers.atoms import (
    HN,
    HP,
    ActionClaim,
    Claim,
    FeedbackType,
    Grounded,
    Moment,
    TruthT,
    Verdict,
    WorldT,
    claim,
    opposed,
)
from worlds.world import World


class ChangeVerdict(Verdict[TruthT, WorldT]):
    """Base of a pair of verdicts on a measure before and after an action; less is better.

    A subclass declares both fields again, at their places among its own.
    """

    __slots__ = ()
    before: float
    after: float

    @override
    def good(self, moment: Moment[TruthT], lab: WorldT) -> bool:
        return self.after < self.before

    def counterparts(self, moment: Moment[TruthT], lab: WorldT) -> Sequence[Claim]:
        """The opposite verdict, with the measures exchanged."""
        return (self.opposing(before=self.after, after=self.before),)


def acted(action: Any, moment: Moment[Any]) -> bool:
    """Whether `action` is the action of this turn."""
    return moment.before is not None and np.array_equal(action, moment.action)


class _Outcome(Verdict[Any]):
    """Whether the task is solved."""

    __slots__ = ()

    def applies(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Every turn with an action, or with a text that did not parse."""
        return moment.action is not None

    @override
    def good(self, moment: Moment[Any], lab: World[Any]) -> bool:
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


class _Judged(Grounded[Any], ActionClaim[Any]):
    """A verdict on the action of this turn that gives no reason; its ground is all hindsight on that action.

    Hindsight that is `relative` is no verdict, and does not count.
    """

    __slots__ = ()
    action_slot = ""

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Check the ground: false blame counts as praise, and false praise as blame."""
        ground = (each for each in self._ground if not each.relative)
        kinds = {HP if (each.kind is HP) == each.holds(moment, lab) else HN for each in ground}
        return acted(self.action, moment) and self._fits(kinds)

    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        """Ask the oracle for hindsight."""
        hindsight = oracle.judge(moment._replace(over=True), {HP, HN})
        kinds = {each.kind for each in hindsight if not each.relative}
        return acted(self.action, moment) and self._fits(kinds)

    @staticmethod
    @abstractmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        """Whether the verdict holds if hindsight has these kinds."""


@claim
class Right(_Judged):
    """True if all hindsight on the action of this turn, of which there is some, is praise."""

    kind = HP
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return kinds == {HP}

    @override
    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        return (Wrong.on(self._ground, action=self.action),)

    def excludes(self, other: Claim[Any]) -> bool:
        """Any blame."""
        return other.kind is HN and not other.placebo


@claim
class PartlyRight(_Judged):
    """True if hindsight on the action of this turn is praise and blame."""

    kind = HP
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return kinds == {HP, HN}

    @override
    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        return (Right.on(self._ground, action=self.action),)

    @override
    def excludes(self, other: Claim[Any]) -> bool:
        return isinstance(other, Right)


@claim
class Wrong(_Judged):
    """True if some hindsight on the action of this turn is blame: something was wrong with it."""

    kind = HN
    action: Any

    @staticmethod
    def _fits(kinds: Set[FeedbackType | None]) -> bool:
        return HN in kinds

    @override
    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        return (Right.on(self._ground, action=self.action),)
