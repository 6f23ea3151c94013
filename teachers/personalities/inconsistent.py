"""inconsistent(likelihood, consistency): speaks with one probability, and is right with another."""

import numpy as np

from teachers.personality import Claims, View, personality
from teachers.spec import Share


@personality(source="Griffith et al. 2013", honest=False)
def inconsistent(
    claims: Claims, view: View, rng: np.random.Generator, *, likelihood: Share = 0.8, consistency: Share = 0.9
) -> Claims:
    """Says each claim with probability `likelihood`; a claim that it says stays true with probability `consistency`.

    A claim that should become false, without a plausible false counterpart, is withheld.
    """
    said = []
    for claim, (speaks, errs) in zip(claims, rng.random((len(claims), 2)).tolist(), strict=True):
        if speaks < likelihood:
            said.append(claim if errs < consistency else view.distort(claim, rng))
    return [claim for claim in said if claim is not None]
