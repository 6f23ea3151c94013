"""limited_knowledge(fraction): knows only part of the states, and is silent about the others."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim, R
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class LimitedKnowledge(Personality):
    """Says a claim iff it knows the state in which the action was or will be taken that the claim is about.

    Which states it knows is fixed once and for all. Rewards (r) are there for everybody to see.
    """

    fraction: float = 0.5
    """Share of the states that it knows, 0 to 1."""

    source = "Bignold et al. 2021; Fachantidis et al. 2019"

    def __post_init__(self) -> None:
        check_range("fraction", self.fraction, 0, 1)

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """What it knows of."""
            known = self.spec.fraction
            return [claim for claim in claims if claim.kind is R or view.share(view.state_of(claim)) < known]
