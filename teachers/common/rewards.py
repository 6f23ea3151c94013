"""Claims about the reward of a turn."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

from typing_extensions import override

from teachers.atoms import Claim, Moment, R, claim
from worlds.world import World

SIGNS = ("positive", "negative", "zero")
"""The signs of a reward."""


def as_said(number: float) -> str:
    """A reward or value as phrases state it: to four significant digits."""
    return f"{number + 0.0:.4g}"


def sign_of(reward: float) -> str:
    """Whether a reward is `positive`, `negative` or `zero`."""
    return "positive" if reward > 0 else "negative" if reward < 0 else "zero"


@claim
class Reward(Claim[Any]):
    """True if `reward` is what the world paid for the action of this turn."""

    kind = R
    reward: float

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the reward of the moment."""
        alike = self.reward == moment.reward or (math.isnan(self.reward) and math.isnan(moment.reward))
        return moment.before is not None and alike

    @override
    def means(self, moment: Moment[Any], oracle: Any) -> bool:
        return moment.before is not None and as_said(self.reward) == as_said(moment.reward)

    def excludes(self, other: Claim[Any]) -> bool:
        """Any other reward, and any other sign."""
        if isinstance(other, Paid):
            return other.sign != sign_of(self.reward)
        return isinstance(other, Reward) and other.reward != self.reward

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """Another reward within the world's range."""
        low, high = lab.reward_range
        others = (1.0 - self.reward, 0.5 * self.reward, low, high)
        return tuple(Reward(reward=r) for r in others if low <= r <= high and r != self.reward)[:1]


@claim
class Paid(Claim[Any]):
    """True if the reward for the action of this turn is so: `positive`, `negative` or `zero`."""

    kind = R
    sign: Annotated[str, SIGNS]

    def holds(self, moment: Moment[Any], lab: World[Any]) -> bool:
        """Compare with the reward of the moment."""
        return moment.before is not None and self.sign == sign_of(moment.reward)

    def excludes(self, other: Claim[Any]) -> bool:
        """Any other sign."""
        return isinstance(other, Paid) and other.sign != self.sign

    def counterparts(self, moment: Moment[Any], lab: World[Any]) -> Sequence[Claim[Any]]:
        """The other signs within the world's range of rewards."""
        low, high = lab.reward_range
        signs = {"positive": high > 0, "negative": low < 0, "zero": low <= 0 <= high}
        return tuple(Paid(sign=sign) for sign, possible in signs.items() if possible and sign != self.sign)
