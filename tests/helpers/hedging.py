"""A personality whose hedges are calibrated by construction."""

from teachers.common import hedge
from teachers.personality import personality


@personality()
def hedging(claims, view, rng, *, low=0.55, high=0.95):
    """Hedges with a drawn probability, in just that share of cases a true claim and else a false counterpart of it."""
    said = []
    for claim in claims:
        p, false = round(rng.uniform(low, high), 2), view.distort(claim, rng)
        if false is not None and view.holds(claim):
            said.append(hedge(claim if rng.random() < p else false, p))
    return said
