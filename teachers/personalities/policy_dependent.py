"""policy_dependent(rate): praises what is better than the student's recent actions and blames what is worse."""

from dataclasses import dataclass

from teachers.atoms import HP
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share
from teachers.view import HINDSIGHT


class _Mean(Stage["PolicyDependent"]):
    """Keeps the exponential mean of the value lost."""

    def begin(self) -> None:
        self._mean: float | None = None
        self._greatest = 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        if view.moment.before is None:
            return claims
        regret = view.regret()
        mean = regret if self._mean is None else self._mean
        first, self._greatest = self._mean is None, max(self._greatest, regret)
        self._mean = mean + self.spec.rate * (regret - mean)
        gain, margin = mean - regret, _MARGIN * self._greatest
        said = {True: first or gain > margin, False: first or gain < -margin}
        return [claim for claim in claims if claim.kind not in HINDSIGHT or said[claim.kind is HP]]


@dataclass(frozen=True)
class PolicyDependent(Personality):
    """Praises (hp) only if the last action lost less value than the student's mean, blames (hn) only if it lost more.

    The mean is exponential. As good actions become usual they are no longer praised: returns diminish until improvement
    is below 5 % of the greatest loss seen. Other claims pass.
    """

    rate: Share = 0.3
    """Weight of the last action in the mean, 0 to 1."""

    source = "COACH: MacGlashan et al. 2017"
    needs = frozenset(("hindsight", "regret"))
    stage = _Mean


_MARGIN = 0.05
