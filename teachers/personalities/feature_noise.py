"""feature_noise(low, high): errs with a probability that depends on the state."""

from typing import Annotated

import numpy as np

from teachers.personality import Claims, View, personality
from teachers.spec import Range, Share


@personality(source="arXiv 2601.01904", honest=False)
def feature_noise(
    claims: Claims,
    view: View,
    rng: np.random.Generator,
    *,
    low: Share = 0.0,
    high: Annotated[float, Range("low", 1)] = 0.5,
) -> Claims:
    """Errs in each claim with a probability that is fixed for each state, uniform from `low` to `high`.

    The state is the one before the action that the claim is about; its feature is a hash. An erring claim without a
    plausible false counterpart is withheld.
    """
    said = []
    for claim, draw in zip(claims, rng.random(len(claims)).tolist(), strict=True):
        eps = low + (high - low) * view.share(view.state_of(claim))
        said.append(view.distort(claim, rng) if draw < eps else claim)
    return [claim for claim in said if claim is not None]
