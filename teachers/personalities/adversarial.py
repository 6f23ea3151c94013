"""adversarial(budget): a few tips that are as bad as possible, among true ones."""

from dataclasses import dataclass
from typing import Any

from teachers.atoms import FP, ActionClaim, Claim
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Count


class _Adversary(Stage["Adversarial"]):
    """Counts false tips, and sums what was at stake."""

    def begin(self) -> None:
        self._left = self.spec.budget
        self._seen, self._total = 0, 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        importance = view.importance()
        self._seen, self._total = self._seen + 1, self._total + importance
        if importance * self._seen < self._total * (1 - 1e-9):  # within rounding
            return claims
        return [self._worst(claim, view) if claim.kind is FP and self._left else claim for claim in claims]

    def _worst(self, claim: Claim[Any], view: View) -> Claim[Any]:
        false = [other for other in view.falsehoods(claim) if other.kind is FP and isinstance(other, ActionClaim)]
        if not false:
            return claim
        self._left -= 1
        return max(false, key=lambda other: view.loss(other.action))


@dataclass(frozen=True)
class Adversarial(Personality):
    """Replaces advice (fp) by false advice of the worst action, whenever at least the average is at stake.

    The budget counts claims of an episode. Advice without a false counterpart about an action passes.
    """

    budget: Count = 3
    """False tips, at least 0."""

    source = "folk"
    needs = frozenset(("advice", "importance", "regret"))
    honest = False
    stage = _Adversary
