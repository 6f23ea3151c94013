"""inactive(plus, minus): mostly keeps silent about actions, good or bad."""

from dataclasses import dataclass

from teachers.personalities.reward_focused import RewardFocused


@dataclass(frozen=True)
class Inactive(RewardFocused):
    """Withholds verdicts as `reward_focused` does, with other probabilities."""

    plus: float = 0.9
    """Probability of silence about what was good, mu+ in the source, 0 to 1."""
    minus: float = 0.9
    """Probability of silence about what was bad, mu- in the source, 0 to 1."""
