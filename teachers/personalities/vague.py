"""vague(q): drops numbers and names from what it says."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Vague(Personality):
    """Replaces each claim with probability q by what is left of it without numbers and names; it says nothing twice.

    Of a reward its sign is left, of verdicts "right" or "wrong", of advice and warnings that there is something to do
    or to avoid. A claim that does not hold stays as it is.
    """

    q: float = 0.5
    """Probability, 0 to 1."""

    source = "Shute 2008"

    def __post_init__(self) -> None:
        check_range("q", self.q, 0, 1)

    class Stage(Stage):
        """Draws once a claim."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The claims, some of them without what they name."""
            drops = (self.rng.random(len(claims)) < self.spec.q).tolist()
            said = [view.vague(claim) if drop else claim for claim, drop in zip(claims, drops, strict=True)]
            return list(dict.fromkeys(said))
