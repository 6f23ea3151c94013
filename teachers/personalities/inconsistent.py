"""inconsistent(likelihood, consistency): speaks with one probability, and is right with another."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Inconsistent(Personality):
    """Says each claim with probability `likelihood`, and then the true one with probability `consistency`.

    A claim to be turned into a false one that has no plausible counterpart is withheld.
    """

    likelihood: float = 0.8
    """Probability of speaking, 0 to 1."""
    consistency: float = 0.9
    """Probability of being right, 0 to 1."""

    source = "Griffith et al. 2013"
    honest = False

    def __post_init__(self) -> None:
        check_range("likelihood", self.likelihood, 0, 1)
        check_range("consistency", self.consistency, 0, 1)

    class Stage(Stage):
        """Draws twice a claim."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Some of the claims, or what is false instead."""
            said = []
            for claim, (speaks, errs) in zip(claims, self.rng.random((len(claims), 2)).tolist(), strict=True):
                if speaks < self.spec.likelihood:
                    said.append(claim if errs < self.spec.consistency else view.distort(claim, self.rng))
            return [claim for claim in said if claim is not None]
