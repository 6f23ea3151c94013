"""The claims of the exact tier; their checks use Bellman's equation or play."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from typing_extensions import override

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, PlanClaim, Verdict, claim, opposed, slot
from teachers.planning.exact.worths import NOTHING, Worth, Worths
from worlds.wrapped.gym_world import GymWorld, Position

_DIGITS = 3  # of what is lost


def in_actions(number: float) -> str:
    """A time as a number of actions."""
    return f"{number:.{_DIGITS}g} action{'s' * (number != 1)}"


@claim
class Total(Claim[Position, GymWorld]):
    """True if the sum of the rewards of an episode counts, of equal sums the one with fewer actions, and an episode has
    at most `turns` actions.
    """  # noqa: D205

    turns: int

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare with what the values are of."""
        return lab.model.gamma is None and bool(lab.model.at(moment.after, lab).horizon == self.turns)


@claim
class Discounted(Claim[Position, GymWorld]):
    """True if the sum of rewards counts, each of them worth `gamma` times what it would be one action earlier."""

    gamma: float

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare with what the values are of."""
        return bool(lab.model.gamma == self.gamma)


@claim
class Fading(Claim[Position, GymWorld]):
    """True if each action before a reward takes this part of the whole reward away."""

    part: float

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Compare the factors of rewards after 0, 1 and 10 actions with a straight line."""
        values = lab.model.at(moment.after, lab)
        left = [values.share(turn) for turn in (0, 1, 10)]
        return all(abs(left[0] - turn * self.part - share) < 1e-9 for turn, share in zip((0, 1, 10), left, strict=True))


@claim
class _Chosen(Verdict[Position, GymWorld], ActionClaim[Position, GymWorld]):
    """Base of verdicts by an action's expected result; luck does not count."""

    action_slot = "answer"
    action: int
    answer: str
    """The action as a student writes it."""
    lost: float
    """Its loss, in reward or in actions, to three digits."""

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether this was the action, and actions differ in that state."""
        acted = moment.before is not None and moment.action == self.action
        return acted and loss(self.action, moment.past, moment, lab) is not None

    @override
    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        return loss(self.action, moment.past, moment, lab) == NOTHING

    @override
    def worth(self, moment: Moment[Position], lab: GymWorld, action: Any) -> float | None:
        values, past = lab.model.at(moment.past, lab), moment.past
        turn = used(past, moment, values)
        return None if turn is None else values.ranked(values.expected(past.seen, turn))[action]

    @override
    def stated_worth(self, moment: Moment[Position], lab: GymWorld, action: Any) -> float | None:
        values, past = lab.model.at(moment.past, lab), moment.past
        turn = used(past, moment, values)
        return None if turn is None else values.expected(past.seen, turn)[action].earned


@claim
class WellChosen(_Chosen):
    """True if no action was better, and another one worse: by the sum that could be expected; of equal sums, without a
    discount, by the number of actions.
    """  # noqa: D205

    kind = HP

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether it loses nothing."""
        return self.lost == 0 and _Chosen.applies(self, moment, lab)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Blame."""
        lost = rounded(lab.model.spread)
        return self.opposing(lost=lost), Slower(action=self.action, answer=self.answer, lost=2.0)


@claim
class _Blame(_Chosen):
    """Base of blame that says how much is lost."""

    @override
    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        return self.applies(moment, lab) and self.tells(loss(self.action, moment.past, moment, lab))

    def tells(self, lost: Worth | None) -> bool:
        """Whether `lost` states this loss."""
        return lost is not None and _near(self.lost, lost.earned)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Praise."""
        return (self.opposing(lost=0.0),)


@claim
class PoorlyChosen(_Blame):
    """True if another action could be expected to earn `lost` more."""

    kind = HN


@claim
class Slower(_Blame):
    """True if another action could be expected to earn as much, and the episode to be over `lost` actions sooner."""

    kind = HN
    time = slot(in_actions, "lost")

    def tells(self, lost: Worth | None) -> bool:
        """Whether `lost` states the actions lost."""
        return lost is not None and _near(self.lost, lost.length)


@claim
class _Tried(_Chosen):
    """Base of verdicts on an action that was tried at the start."""

    tried = True

    def applies(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Whether actions differ at the start, and `lost` is the action's loss."""
        lost = loss(self.action, moment.after, moment, lab)
        return lost is not None and (_near(self.lost, lost.earned) or lost.earned == self.lost == 0)

    @override
    def good(self, moment: Moment[Position], lab: GymWorld) -> bool:
        return self.lost == 0

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The opposite verdict, with another number."""
        return (self.opposing(lost=0.0 if self.lost else rounded(lab.model.spread)),)


@claim
class TriedWell(_Tried):
    """True if at the start no action can be expected to earn more."""

    kind = HP


@claim
class TriedPoorly(_Tried):
    """True if at the start another action can be expected to earn `lost` more."""

    kind = HN


opposed(WellChosen, PoorlyChosen)
opposed(TriedWell, TriedPoorly)
Slower.opposite = WellChosen


@claim
class Choose(ActionClaim[Position, GymWorld]):
    """True if no action is better now, and another one worse: as in `WellChosen`."""

    kind = FP
    action_slot = "answer"
    action: int
    answer: str

    @override
    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        return loss(self.action, moment.after, moment, lab) == NOTHING

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Advise another action."""
        return tuple(Choose(action=action, answer=answer_of(action, lab)) for action in _others(self.action, lab))


@claim
class Avoid(ActionClaim[Position, GymWorld]):
    """True if another action can be expected to earn `lost` more than `action` now."""

    kind = FN
    action_slot = "answer"
    action: int
    answer: str
    lost: float

    @override
    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        lost = loss(self.action, moment.after, moment, lab)
        return lost is not None and _near(self.lost, lost.earned)

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """Warn of another action."""
        others = _others(self.action, lab)
        return tuple(replace(self, action=action, answer=answer_of(action, lab)) for action in others)


@claim
class Dawdle(Avoid):
    """True if another action can be expected to earn as much, and the episode to be over `lost` actions sooner."""

    time = slot(in_actions, "lost")

    @override
    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        lost = loss(self.action, moment.after, moment, lab)
        return lost is not None and _near(self.lost, lost.length)


@claim
class Route(PlanClaim[Position, GymWorld]):
    """True if these actions from the start earn as much as can be earned; without a discount, in the fewest actions."""

    actions: tuple[int, ...]
    listing: str

    def holds(self, moment: Moment[Position], lab: GymWorld) -> bool:
        """Take the actions and add their rewards."""
        start, earned = moment.after, 0.0
        lab.restore(start)
        for turn, action in enumerate(self.actions):
            _, reward, terminated, truncated, _ = lab.advance(action)
            earned += reward * (1.0 if lab.model.gamma is None else lab.model.gamma**turn)
            if (terminated or truncated) and turn + 1 < len(self.actions):
                return False
        values = lab.model.at(start, lab)
        best = values.best(values.expected(start.seen, start.turn))
        short = lab.model.gamma is not None or len(self.actions) <= best.length
        return short and bool(values.equals(earned, best.earned))

    def counterparts(self, moment: Moment[Position], lab: GymWorld) -> Sequence[Claim]:
        """The same actions backwards."""
        return (route(self.actions[::-1], lab),)


def route(actions: Sequence[int], lab: GymWorld) -> Route:
    """A route of these actions."""
    return Route(actions=tuple(actions), listing=", ".join(answer_of(action, lab) for action in actions))


def answer_of(action: int, lab: GymWorld) -> str:
    """An action as a student writes it."""
    return lab.names.get(action, str(action))


def rounded(value: float) -> float:
    """Round to three digits."""
    return float(f"{value:.{_DIGITS}g}")


def used(truth: Position, moment: Moment[Position], values: Worths) -> int | None:
    """Turns used up in a state of a moment, by actions and by texts that did not parse.

    None if there were such texts and rewards fade with each action: then the values are not known.
    """
    unread = max(0, moment.turn - moment.after.turn)
    return None if unread and values.fades else truth.turn + unread


def loss(action: int, truth: Position, moment: Moment[Position], lab: GymWorld) -> Worth | None:
    """The loss of an action against the best one, by Bellman's equation; None if it, or every loss, is too small.

    Args:
        action: the action.
        truth: the state, the moment's `past` or `after`.
        moment: gives the number of turns that are left.
        lab: has the model.
    """
    values = lab.model.at(truth, lab)
    turn = used(truth, moment, values)
    if turn is None:
        return None
    worths = values.expected(truth.seen, turn)
    all_lost = values.all_lost(worths)
    return all_lost[action] if any(map(any, filter(None, all_lost))) else None


def _near(said: float, lost: float) -> bool:
    """Whether there is a loss, and `said` states it to three digits."""
    return lost > 0 and abs(said - lost) <= 0.51 * 10 ** (1 - _DIGITS) * lost


def _others(action: int, lab: GymWorld) -> list[int]:
    return [other for other in range(lab.model.actions) if other != action]
