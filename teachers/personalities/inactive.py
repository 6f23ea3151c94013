"""inactive(plus, minus): mostly keeps silent about actions, good or bad."""

import numpy as np

from teachers.personalities.reward_focused import some_verdicts
from teachers.personality import Claims, View, personality
from teachers.spec import Share


@personality(source="Loftin et al. 2014", needs=("hindsight",))
def inactive(claims: Claims, view: View, rng: np.random.Generator, *, plus: Share = 0.9, minus: Share = 0.9) -> Claims:
    """Withholds verdicts as `reward_focused` does, with other probabilities."""
    return some_verdicts(claims, rng, plus, minus)
