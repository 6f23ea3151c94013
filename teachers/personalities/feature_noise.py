"""feature_noise(low, high): errs with a probability that depends on the state."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class FeatureNoise(Personality):
    """Errs in each claim with a probability that the state has once and for all, spread evenly from `low` to `high`.

    The state is the one in which the action was or will be taken that the claim is about; its feature is a hash. A
    claim to be replaced that has no plausible false counterpart is withheld.
    """

    low: float = 0.0
    """Least probability of an error, 0 to 1."""
    high: float = 0.5
    """Greatest probability of an error, `low` to 1."""

    source = "arXiv 2601.01904"
    honest = False

    def __post_init__(self) -> None:
        check_range("low", self.low, 0, 1)
        check_range("high", self.high, self.low, 1)

    class Stage(Stage):
        """Draws once a claim."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Each claim, or what is false instead."""
            low, high = self.spec.low, self.spec.high
            said = []
            for claim, draw in zip(claims, self.rng.random(len(claims)).tolist(), strict=True):
                eps = low + (high - low) * view.share(view.state_of(claim))
                said.append(view.distort(claim, self.rng) if draw < eps else claim)
            return [claim for claim in said if claim is not None]
