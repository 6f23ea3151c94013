"""verbose(k): says the same claims among useless sentences."""

from typing import Annotated

import numpy as np

from teachers.common import FACTS, Truism
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="Shute 2008")
def verbose(claims: Claims, view: View, rng: np.random.Generator, *, k: Annotated[int, Range(0, 100)] = 3) -> Claims:
    """Inserts k truisms a turn at random places among the claims; without claims it is silent.

    A truism has the kind of one of the claims, so that it is withheld if that kind is.
    """
    said = list(claims)
    for _ in range(k if claims else 0):
        kind = claims[int(rng.integers(len(claims)))].kind
        place = rng.integers(len(said) + 1)
        said.insert(int(place), Truism(kind=kind, fact=FACTS[rng.integers(len(FACTS))]))
    return said
