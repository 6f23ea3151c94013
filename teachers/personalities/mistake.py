"""mistake(eps): with probability eps each claim is replaced by its false counterpart (B-Pref's eps_mistake)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Mistake(Personality):
    """Errs independently per claim. A claim to be replaced that has no plausible false counterpart is withheld."""

    eps: float = 0.1
    """Probability of an error, 0 to 1."""
    source = "B-Pref eps_mistake"
    honest = False

    def __post_init__(self) -> None:
        check_range("eps", self.eps, 0, 1)

    class Stage(Stage):
        """Draws once a claim."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Each claim, or what is false instead."""
            wrong = self.rng.random(len(claims)) < self.spec.eps
            said = [view.distort(c, self.rng) if err else c for c, err in zip(claims, wrong.tolist(), strict=True)]
            return [claim for claim in said if claim is not None]
