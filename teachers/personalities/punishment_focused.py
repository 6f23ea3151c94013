"""punishment_focused(plus, minus): blames bad actions and mostly keeps silent about good ones."""

from dataclasses import dataclass

from teachers.personalities.reward_focused import RewardFocused


@dataclass(frozen=True)
class PunishmentFocused(RewardFocused):
    """Withholds verdicts as `reward_focused` does, with other probabilities."""

    plus: float = 0.9
    """Probability of silence about what was good, mu+ in the source, 0 to 1."""
    minus: float = 0.1
    """Probability of silence about what was bad, mu- in the source, 0 to 1."""
