"""mix: a random non-empty subset of the kinds, drawn anew each turn (LLF-Bench's feedback type `m`)."""

import numpy as np

from teachers.feedback import draw_kinds
from teachers.personality import Claims, View, personality


@personality(source="LLF-Bench's `m`")
def mix(claims: Claims, view: View, rng: np.random.Generator) -> Claims:
    """Each non-empty subset of the wanted kinds is equally likely; a turn without claims of these kinds is silent."""
    kinds = draw_kinds(view.kinds, rng)
    return [claim for claim in claims if claim.kind in kinds]
