"""punishment_focused(plus, minus): blames bad actions and mostly keeps silent about good ones."""

import numpy as np

from teachers.personalities.reward_focused import some_verdicts
from teachers.personality import Claims, View, personality
from teachers.spec import Share


@personality(source="Loftin et al. 2014", needs=("hindsight",))
def punishment_focused(
    claims: Claims, view: View, rng: np.random.Generator, *, plus: Share = 0.9, minus: Share = 0.1
) -> Claims:
    """Withholds verdicts as `reward_focused` does, with other probabilities."""
    return some_verdicts(claims, rng, plus, minus)
