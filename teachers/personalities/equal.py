"""equal(eps): says that it makes no difference where values differ by less than a margin."""

from dataclasses import dataclass

from teachers.atoms import HN, HP
from teachers.common import NoDifference
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share
from teachers.view import HINDSIGHT, first_of


class _Comparison(Stage["Equal"]):
    """Keeps the running mean of what was at stake."""

    def begin(self) -> None:
        self._turns, self._total = 0, 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        values, action = view.past_stated_values(), view.moment.action
        if values is None:
            return claims
        self._turns, self._total = self._turns + 1, self._total + max(values) - min(values)
        margin = self.spec.eps * self._total / self._turns
        mine, other = values[action], max(value for each, value in enumerate(values) if each != action)
        verdict = next((c for c in view.hindsight() if c.kind is (HP if mine >= other else HN)), None)
        at = first_of(HINDSIGHT, claims)
        if verdict is None or abs(mine - other) >= margin * _BELOW or at is None:
            return claims
        same = NoDifference.on(verdict, action=action, mine=mine, other=other, margin=margin)
        return [*claims[:at], same, *(claim for claim in claims[at:] if claim.kind not in HINDSIGHT)]


@dataclass(frozen=True)
class Equal(Personality):
    """Replaces verdicts on the last action by "no difference" if the best other action is within a margin of it.

    The margin is eps times the running mean of what was at stake. Other claims pass. Tied actions are equal under any
    margin above 0.
    """

    eps: Share = 0.1
    """The margin as a share of the scale, 0 to 1."""

    source = "B-Pref eps_equal"
    needs = frozenset(("hindsight", "values"))
    stage = _Comparison


_BELOW = 1 - 1e-9  # equal within rounding is not below
