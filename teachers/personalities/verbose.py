"""verbose(k): says the same among useless sentences."""

from typing import Annotated

import numpy as np

from teachers.common import FACTS, Truism
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="Shute 2008")
def verbose(claims: Claims, view: View, rng: np.random.Generator, *, k: Annotated[int, Range(0, 100)] = 3) -> Claims:
    """Scatters k truisms a turn among the claims, in their order; it is silent where there is nothing to say.

    A truism has the kind of one of the claims, so that it is withheld where all these are.
    """
    said = list(claims)
    for _ in range(k if claims else 0):
        kind = claims[int(rng.integers(len(claims)))].kind
        place = rng.integers(len(said) + 1)
        said.insert(int(place), Truism(kind=kind, fact=FACTS[rng.integers(len(FACTS))]))
    return said
