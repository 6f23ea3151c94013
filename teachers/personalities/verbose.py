"""verbose(k): says the same among useless sentences."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.common import FACTS, Truism
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Verbose(Personality):
    """Scatters truisms among the claims, in their order; it is silent where there is nothing to say.

    A truism has the kind of one of the claims, so that it is withheld where all these are.
    """

    k: int = 3
    """Number of truisms a turn, at least 0."""

    source = "Shute 2008"

    def __post_init__(self) -> None:
        check_range("k", self.k, 0, 100, int)

    class Stage(Stage):
        """Draws facts and places."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The claims and what is between them."""
            said = list(claims)
            for _ in range(self.spec.k if claims else 0):
                kind = claims[self.rng.integers(len(claims))].kind
                place = self.rng.integers(len(said) + 1)
                said.insert(int(place), Truism(kind=kind, fact=FACTS[self.rng.integers(len(FACTS))]))
            return said
