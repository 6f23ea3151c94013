"""worked_example(n): shows the next optimal actions at once in place of advice."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import FP, Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class WorkedExample(Personality):
    """Replaces advice (fp) by the next actions of an optimal policy, as far as they can be checked.

    Where none can, the advice stays.
    """

    n: int = 3
    """Greatest number of actions, at least 1."""

    source = "Shute 2008"
    needs = frozenset(("advice", "plan"))

    def __post_init__(self) -> None:
        check_range("n", self.n, 1, 1000, int)

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The example in the place of the first advice."""
            example = view.example(self.spec.n) if any(claim.kind is FP for claim in claims) else None
            if example is None:
                return claims
            others = [claim for claim in claims if claim.kind is not FP]
            at = next(i for i, claim in enumerate(claims) if claim.kind is FP)
            return [*others[:at], example, *others[at:]]
