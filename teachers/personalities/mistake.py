"""mistake(eps): with probability eps each claim is replaced by its false counterpart (B-Pref's eps_mistake)."""

import numpy as np

from teachers.personality import Claims, View, personality
from teachers.spec import Share


@personality(source="B-Pref eps_mistake", honest=False)
def mistake(claims: Claims, view: View, rng: np.random.Generator, *, eps: Share = 0.1) -> Claims:
    """Errs independently per claim. An erring claim without a plausible false counterpart is withheld."""
    wrong = rng.random(len(claims)) < eps
    said = [view.distort(claim, rng) if err else claim for claim, err in zip(claims, wrong.tolist(), strict=True)]
    return [claim for claim in said if claim is not None]
