"""policy_dependent(rate): praises what is better than the student's habit and blames what is worse, less and less."""

from dataclasses import dataclass

from teachers.atoms import HP
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share
from teachers.view import HINDSIGHT


class _Habit(Stage["PolicyDependent"]):
    """Keeps the student's habit."""

    def begin(self) -> None:
        self._habit: float | None = None
        self._greatest = 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        if view.moment.before is None:
            return claims
        regret = view.regret()
        habit = regret if self._habit is None else self._habit
        first, self._greatest = self._habit is None, max(self._greatest, regret)
        self._habit = habit + self.spec.rate * (regret - habit)
        gain, margin = habit - regret, _MARGIN * self._greatest
        said = {True: first or gain > margin, False: first or gain < -margin}
        return [claim for claim in claims if claim.kind not in HINDSIGHT or said[claim.kind is HP]]


@dataclass(frozen=True)
class PolicyDependent(Personality):
    """Says praise (hp) only if the last action lost less value than the student is wont to, blame (hn) only if more.

    The habit is an exponential mean of the value lost. As the student gets used to good actions they earn no praise any
    more: returns diminish until improvement is below 5 % of the greatest loss seen. Other claims pass.
    """

    rate: Share = 0.3
    """Weight of the last action in the mean, 0 to 1."""

    source = "COACH: MacGlashan et al. 2017"
    needs = frozenset(("hindsight", "regret"))
    stage = _Habit


_MARGIN = 0.05
