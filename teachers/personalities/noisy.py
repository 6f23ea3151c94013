"""noisy(beta): praises or blames by chance, with odds by the difference between an action's value and its rival's."""

import math
from typing import Annotated

import numpy as np

from teachers.atoms import HP
from teachers.personality import Claims, View, personality
from teachers.spec import Range
from teachers.view import HINDSIGHT


@personality(source="B-Pref beta", needs=("hindsight", "values"), honest=False)
def noisy(
    claims: Claims, view: View, rng: np.random.Generator, *, beta: Annotated[float, Range(0, 1e9)] = 1.0
) -> Claims:
    """Calls the last action good with the probability that Bradley and Terry's model gives it over its rival.

    That is 1 / (1 + exp(-beta (v - w))) with v the action's value and w the greatest different value of another action,
    its rival; an action without a rival is good. Beta is the rationality: with 0 the verdict is a coin flip, with a
    large beta it follows the values. Verdicts (hp, hn) that differ from the draw are reversed; other claims pass.
    """
    draw, values = rng.random(), view.past_values()
    if values is None:
        return claims
    value = values[view.moment.action]
    rivals = [other for other in values if other != value]
    margin = beta * (value - max(rivals)) if rivals else math.inf
    good = draw < (1 / (1 + math.exp(-margin)) if margin > -700 else 0.0)
    return [
        view.flip(claim, rng) if claim.kind in HINDSIGHT and (claim.kind is HP) != good else claim for claim in claims
    ]
