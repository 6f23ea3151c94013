"""reward_focused(plus, minus): praises good actions and mostly keeps silent about bad ones."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HP, Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range
from teachers.view import HINDSIGHT


@dataclass(frozen=True)
class RewardFocused(Personality):
    """Withholds praise (hp) with probability `plus` and blame (hn) with probability `minus`, drawn once a turn.

    What its silence means depends on these two, which a student can learn. Other claims pass.
    """

    plus: float = 0.1
    """Probability of silence about what was good, mu+ in the source, 0 to 1."""
    minus: float = 0.9
    """Probability of silence about what was bad, mu- in the source, 0 to 1."""

    source = "Loftin et al. 2014"
    needs = frozenset(("hindsight",))

    def __post_init__(self) -> None:
        check_range("plus", self.plus, 0, 1)
        check_range("minus", self.minus, 0, 1)

    class Stage(Stage):
        """Draws once a turn."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Some of the verdicts."""
            draw = self.rng.random()
            said = {True: draw >= self.spec.plus, False: draw >= self.spec.minus}
            return [claim for claim in claims if claim.kind not in HINDSIGHT or said[claim.kind is HP]]
