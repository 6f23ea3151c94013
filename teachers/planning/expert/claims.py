"""The claims of the expert tier; checks ask a new expert and use other roll-outs."""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import spaces

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, PlanClaim, Verdict, claim, opposed
from teachers.planning.expert.asking import ExpertError
from teachers.planning.expert.guide import Guide, Lead
from worlds.wrapped.gym_world import GymWorld, Position

_OTHERS = 10  # counterparts, at most
_TIMES = 100  # what a liar makes of an amount


@claim
class Guided(Claim[Position, GymWorld]):
    """True if actions are judged by what was earned after them in roll-outs of at most `horizon` actions, which follow
    an expert.
    """  # noqa: D205

    horizon: int

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare with the horizon of the roll-outs."""
        return bool(lab.model.horizon == self.horizon)


@claim
class _Compared(ActionClaim[Position, GymWorld]):
    """Base of claims about roll-outs after an action."""

    action_slot = "answer"
    relative = True
    action: Any
    answer: str
    """The action as a student writes it."""
    amount: float
    """Difference of the sums of rewards: the median of all pairs of roll-outs, to three digits."""
    rollouts: int
    """Number of pairs of roll-outs, each pair with equal draws; 1 if they drew nothing."""
    horizon: int
    """Most actions of a roll-out."""

    @property
    def basis(self) -> str:
        """The roll-outs in words."""
        number = "1 roll-out" if self.rollouts == 1 else f"the median of {self.rollouts} roll-outs"
        return f"{number} of at most {self.horizon} action{'s' * (self.horizon != 1)} after each"

    def rests(self, guide: Guide) -> bool:
        """Whether number and horizon of the roll-outs are the guide's."""
        return self.rollouts in (1, guide.rollouts) and self.horizon == guide.horizon


@claim
class _Own(_Compared, Verdict[Position, GymWorld]):
    """Base of comparisons of the student's action with the different action of the expert."""

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether this was the action, and the roll-outs are the guide's."""
        return moment.before is not None and moment.action == self.action and self.rests(lab.model)

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew, and roll out with other draws; see `Guide.confirms`."""
        return self.applies(moment, lab) and _differs(self, moment.past, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The opposite comparison, and another amount."""
        return self.opposing(), replace(self, amount=self.amount * _TIMES)


@claim
class Ahead(_Own):
    """True if following the expert after `action` earned `amount` more than after the expert's own choice.

    What that means where something is left to chance, is said in `teachers.planning.expert.guide.Guide.confirms`.
    """

    kind = HP


@claim
class Behind(_Own):
    """True if following the expert after `action` earned `amount` less than after the expert's own choice."""

    kind = HN


opposed(Ahead, Behind)


@claim
class Followed(_Compared):
    """True if the expert would have taken `action`, too, and earned `amount` more after it than after `other`."""

    kind = HP
    other: Any
    instead: str
    """The other action as a student writes it."""

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew, and roll out with other draws."""
        guide = lab.model
        if moment.before is None or moment.action != self.action or not self.rests(guide):
            return False
        own = _asked(moment.past, lab)
        agrees = own is not None and guide.alike(own, self.action)
        return agrees and guide.confirms(Lead(self.amount, self.rollouts), moment.past, lab, self.action, self.other)

    def excludes(self, other: Claim) -> bool:
        """A comparison with another choice of the expert."""
        return isinstance(other, _Own)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Blame, and another amount."""
        own = {name: getattr(self, name) for name in ("action", "answer", "amount", "rollouts", "horizon")}
        return Behind(**own), replace(self, amount=self.amount * _TIMES)


@claim
class Neared(Followed):
    """True if no number of what the expert would have done is farther than `tolerance` from that of `action`, after
    which it earned `amount` more than after `other`.
    """  # noqa: D205

    tolerance: float

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew, and roll out with other draws."""
        return self.tolerance == lab.model.tolerance and Followed.holds(self, moment, lab)


@claim
class Costs(_Compared):
    """True if following the expert after `action` earns `amount` less than after what the expert would do now."""

    kind = FN

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew, and roll out with other draws."""
        return self.rests(lab.model) and _differs(self, moment.after, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Another amount, and other actions."""
        others = [replace(self, action=action, answer=answer_of(action, lab)) for action in _others(self, moment, lab)]
        return replace(self, amount=self.amount * _TIMES), *others


@claim
class Would(ActionClaim[Position, GymWorld]):
    """True if the expert, asked anew in this state, would take `action`."""

    kind = FP
    action_slot = "answer"
    relative = True
    action: Any
    answer: str

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew."""
        own = _asked(moment.after, lab)
        return own is not None and bool(lab.model.alike(own, self.action))

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Other actions."""
        return tuple(
            replace(self, action=action, answer=answer_of(action, lab)) for action in _others(self, moment, lab)
        )


@claim
class Around(Would):
    """True if no number of what the expert would do now is farther than `tolerance` from that of `action`."""

    tolerance: float

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Ask anew."""
        return self.tolerance == lab.model.tolerance and Would.holds(self, moment, lab)


@claim
class Demonstration(PlanClaim[Position, GymWorld]):
    """True if the expert takes these actions from the start on."""

    actions: tuple[Any, ...]
    listing: str

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Watch the expert from the start."""
        try:
            return bool(lab.model.demonstrate(moment.after, lab, len(self.actions), anew=True) == self.actions)
        except ExpertError:
            return False

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The same actions backwards."""
        return (shown(self.actions[::-1], lab),)


def shown(actions: Sequence[Any], lab: GymWorld) -> Demonstration:
    """A demonstration of these actions."""
    return Demonstration(actions=tuple(actions), listing=", ".join(answer_of(action, lab) for action in actions))


def is_real(action: Any) -> bool:
    """Whether an action has real numbers; claims state an expert's only to within a tolerance."""
    return any(map(is_real, action)) if isinstance(action, tuple) else isinstance(action, float)


def answer_of(action: Any, lab: GymWorld) -> str:
    """An action as a student writes it."""
    if (name := lab.names.get(action)) is not None:
        return name
    return action if isinstance(action, str) else json.dumps(_plain(action, lab.action_space))


def _plain(action: Any, space: spaces.Space[Any]) -> Any:
    """An action in JSON types; a 32-bit float gets the fewest digits that read back equal."""
    if isinstance(space, spaces.Dict):
        return {key: _plain(item, space[key]) for key, item in action}
    if isinstance(space, spaces.Tuple):
        return [_plain(item, part) for item, part in zip(action, space.spaces, strict=True)]
    if isinstance(action, tuple):
        inner = space.feature_space if isinstance(space, spaces.Sequence) else space
        return [_plain(item, inner) for item in action]
    return float(str(np.float32(action))) if isinstance(action, float) and np.float32(action) == action else action


def _asked(truth: Position, lab: GymWorld) -> Any:
    """The action of the expert, asked anew; None if it gives no answer."""
    try:
        return lab.model.action(truth, lab, anew=True)
    except ExpertError:
        return None


def _differs(said: _Compared, truth: Position, lab: GymWorld) -> bool:
    """Whether the action earns so much more (hp) or less (hn) than the different action of the expert, asked anew."""
    own = _asked(truth, lab)
    if own is None or lab.model.alike(own, said.action):
        return False
    lead = Lead(said.amount if said.kind is HP else -said.amount, said.rollouts)
    return bool(lab.model.confirms(lead, truth, lab, said.action, own))


def _others(said: ActionClaim[Position, GymWorld], moment: Moment[Position], lab: GymWorld) -> list[Any]:
    """Actions other than the claim's."""
    return list(lab.model.candidates(moment.after, lab, said.action, _OTHERS))
