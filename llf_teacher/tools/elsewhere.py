"""How often claims would hold elsewhere, which measures what a listener can take from them."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.episodes.record import claim_name
from teachers.atoms import FN, FP, Claim, Moment, PlanClaim, action_of
from teachers.oracle import Oracle

COMMON = 0.95
"""A claim class that holds in a greater share of other places needs a reason to be said: `Claim.commonplace`."""
_SAMPLES = 40  # of a claim class in an audit
_EPISODES = 6  # that are kept to ask of
_TRIES = 20  # to draw an action that differs


class Elsewhere(NamedTuple):
    """In how many other places claims of a class were checked, and in how many of them they hold."""

    actions: int = 0
    """Checks with another action in the moment and in the claim's own field."""
    held_actions: int = 0
    moments: int = 0
    """Checks in a moment of another episode; of verdicts, after an action there, which they are then on."""
    held_moments: int = 0
    commonplace: str = ""
    """Why the claims are said if they hold nearly everywhere."""

    def __add__(self, other: "Elsewhere") -> "Elsewhere":  # type: ignore[override]  # no concatenation
        """Both together."""
        actions, held_actions, moments, held_moments, _ = other
        return Elsewhere(
            self.actions + actions,
            self.held_actions + held_actions,
            self.moments + moments,
            self.held_moments + held_moments,
            self.commonplace,
        )

    @property
    def shares(self) -> tuple[float | None, float | None]:
        """The share of other actions, and of other moments, in which the claims hold; None without checks."""
        pairs = ((self.held_actions, self.actions), (self.held_moments, self.moments))
        return tuple(held / checks if checks else None for held, checks in pairs)  # type: ignore[return-value]  # two

    @property
    def empty(self) -> bool:
        """Whether the claims hold with nearly every action and in nearly every moment, and no reason is given."""
        shares = [share for share in self.shares if share is not None]
        return not self.commonplace and min(shares, default=0.0) > COMMON


class _Episode(NamedTuple):
    oracle: Oracle
    """Has started on the episode."""
    moments: Sequence[Moment[Any]]

    def holds(self, claim: Claim[Any], moment: Moment[Any]) -> bool:
        """Whether a claim holds of a moment of the episode; without its ground, if it has one."""
        return claim.within(self.moments.__getitem__, moment.turn).means(moment, self.oracle)


class Places:
    """Checks claims of one environment elsewhere.

    Args:
        family: the name of its family.
        rng: draws the actions and moments.
    """

    def __init__(self, family: str, rng: np.random.Generator) -> None:
        self._family, self._rng = family, rng
        self._episodes: list[_Episode] = []
        self.found: dict[str, Elsewhere] = {}
        """By the name of the claim class."""

    def add(self, oracle: Oracle, moments: Sequence[Moment[Any]], said: Mapping[int, Sequence[Claim[Any]]]) -> None:
        """Add an episode, and check its claims elsewhere.

        Args:
            oracle: an oracle of its own, which this starts.
            moments: all moments, the opening first.
            said: feedback by the turn that it is about.
        """
        oracle.start(moments[0].after)
        here = _Episode(oracle, moments)
        for turn, claims in said.items():
            for claim in claims:
                self._check(claim, here, moments[turn])
        self._episodes = [*self._episodes[1 - _EPISODES :], here]

    def _check(self, claim: Claim[Any], here: _Episode, moment: Moment[Any]) -> None:
        name = claim_name(claim, self._family)
        found = self.found.get(name, Elsewhere(commonplace=claim.commonplace))
        if found.moments < _SAMPLES:
            self.found[name] = found + self._with_another_action(claim, here, moment) + self._elsewhere(claim, moment)

    def _with_another_action(self, claim: Claim[Any], here: _Episode, moment: Moment[Any]) -> Elsewhere:
        """Check a verdict after another action, and advice of another action; of a plan, with another first action."""
        ahead = claim.kind in (FP, FN) and (_has_action(claim) or isinstance(claim, PlanClaim))
        truth = moment.after if ahead else moment.before
        if truth is None:
            return Elsewhere()
        lab = here.oracle.lab
        lab.restore(truth)
        own = action_of(claim) if ahead else moment.action
        drawn = (lab.legal(lab.sample_action(self._rng)) for _ in range(_TRIES))
        action = next((each for each in drawn if each != own), None)
        if action is None:
            return Elsewhere()
        if not ahead:
            tried = here.oracle.try_out(Moment.opening(truth, moment.turn - 1), action)
            moment = tried._replace(over=moment.over)
        if isinstance(claim, PlanClaim):
            claim = replace(claim, actions=(action, *claim.actions[1:]))  # type: ignore[type-var]  # a dataclass
        elif _names(claim, own):
            claim = replace(claim, action=action)  # type: ignore[type-var]
        return Elsewhere(actions=1, held_actions=here.holds(claim, moment))

    def _elsewhere(self, claim: Claim[Any], moment: Moment[Any]) -> Elsewhere:
        """Check a claim in a moment of another episode."""
        if not self._episodes:
            return Elsewhere()
        there = self._episodes[self._rng.integers(len(self._episodes))]
        ahead = claim.kind in (FP, FN)
        places = [each for each in there.moments if ahead or each.before is not None]
        if not places:
            return Elsewhere()
        place = places[int(self._rng.integers(len(places)))]
        if not ahead and _names(claim, moment.action):
            claim = replace(claim, action=place.action)  # type: ignore[type-var]  # a dataclass
        return Elsewhere(moments=1, held_moments=there.holds(claim, place))


def _has_action(claim: Claim[Any]) -> bool:
    return any(field.name == "action" for field in fields(claim))  # type: ignore[arg-type]  # a dataclass


def _names(claim: Claim[Any], action: Any) -> bool:
    """Whether an action is the claim's own."""
    return _has_action(claim) and bool(claim.action == action)  # type: ignore[attr-defined]  # it has one
