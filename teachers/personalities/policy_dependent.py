"""policy_dependent(rate): praises what is better than the student's habit and blames what is worse, less and less."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HP, Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range
from teachers.view import HINDSIGHT


@dataclass(frozen=True)
class PolicyDependent(Personality):
    """Says praise (hp) only if the last action lost less value than the student is wont to, blame (hn) only if more.

    The habit is an exponential mean of the value lost. As the student gets used to good actions they earn no praise any
    more: returns diminish until improvement is below 5 % of the greatest loss seen. Other claims pass.
    """

    rate: float = 0.3
    """Weight of the last action in the mean, 0 to 1."""

    source = "COACH: MacGlashan et al. 2017"
    needs = frozenset(("hindsight", "regret"))

    def __post_init__(self) -> None:
        check_range("rate", self.rate, 0, 1)

    class Stage(Stage):
        """Keeps the student's habit."""

        def begin(self) -> None:
            """There is none yet."""
            self._habit: float | None = None
            self._greatest = 0.0

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Verdicts that compare with the habit."""
            if view.moment.before is None:
                return claims
            regret = view.regret()
            habit = regret if self._habit is None else self._habit
            first, self._greatest = self._habit is None, max(self._greatest, regret)
            self._habit = habit + self.spec.rate * (regret - habit)
            gain, margin = habit - regret, _MARGIN * self._greatest
            said = {True: first or gain > margin, False: first or gain < -margin}
            return [claim for claim in claims if claim.kind not in HINDSIGHT or said[claim.kind is HP]]


_MARGIN = 0.05
