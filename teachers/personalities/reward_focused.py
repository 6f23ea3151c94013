"""reward_focused(plus, minus): praises good actions and mostly keeps silent about bad ones."""

import numpy as np

from teachers.atoms import HP
from teachers.personality import Claims, View, personality
from teachers.spec import Share
from teachers.view import HINDSIGHT


@personality(source="Loftin et al. 2014", needs=("hindsight",))
def reward_focused(
    claims: Claims, view: View, rng: np.random.Generator, *, plus: Share = 0.1, minus: Share = 0.9
) -> Claims:
    """Withholds praise (hp) with probability `plus` and blame (hn) with probability `minus`, drawn once a turn.

    These are mu+ and mu- in the source. They decide what silence means, which a student can learn. Other claims pass.
    """
    return some_verdicts(claims, rng, plus, minus)


def some_verdicts(claims: Claims, rng: np.random.Generator, plus: float, minus: float) -> Claims:
    """The claims without praise or without blame, each with its probability."""
    draw = rng.random()
    said = {True: draw >= plus, False: draw >= minus}
    return [claim for claim in claims if claim.kind not in HINDSIGHT or said[claim.kind is HP]]
