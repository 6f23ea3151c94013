"""vague(q): drops numbers and names from what it says."""

import numpy as np

from teachers.personality import Claims, View, personality
from teachers.spec import Share


@personality(source="Shute 2008")
def vague(claims: Claims, view: View, rng: np.random.Generator, *, q: Share = 0.5) -> Claims:
    """Removes numbers and names from each claim with probability q; equal claims are said once.

    A reward becomes its sign, a verdict "right" or "wrong", advice and warnings that there is something to do or to
    avoid. A claim that does not hold passes.
    """
    drops = (rng.random(len(claims)) < q).tolist()
    said = [view.vague(claim) if drop else claim for claim, drop in zip(claims, drops, strict=True)]
    return list(dict.fromkeys(said))
