"""noisy(beta): praises or blames by chance, with odds by the difference between an action's value and its rival's."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from teachers.atoms import HP
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range
from teachers.view import HINDSIGHT


class _Odds(Stage["Noisy"]):
    """Keeps the running mean of the variance of values."""

    def begin(self) -> None:
        self._turns, self._total = 0, 0.0

    def speak(self, claims: Claims, view: View) -> Claims:
        draw, values = self.rng.random(), view.past_values()
        if values is None:
            return claims
        self._turns, self._total = self._turns + 1, self._total + float(np.var(values))
        good = draw < self._chance(values[view.moment.action], values)
        return [
            view.flip(claim, self.rng) if claim.kind in HINDSIGHT and (claim.kind is HP) != good else claim
            for claim in claims
        ]

    def _chance(self, value: float, values: tuple[float, ...]) -> float:
        """The probability that the action is called good."""
        rivals = [other for other in values if other != value]
        if not rivals:
            return 1.0
        unit = math.sqrt(self._total / self._turns) if self.spec.scaled else 1.0
        margin = self.spec.beta * (value - max(rivals)) / (unit or _LEAST)
        return 1 / (1 + math.exp(-margin)) if margin > -700 else 0.0


@dataclass(frozen=True)
class Noisy(Personality):
    """Calls the last action good with the probability that Bradley and Terry's model gives it over its rival.

    That is 1 / (1 + exp(-beta (v - w) / s)) with v the action's value, w the greatest different value of another
    action, its rival, and s the spread of values; an action without a rival is good. The variance of the values of all
    actions in a state, averaged over the student's actions so far, is s squared. So the verdicts do not depend on the
    unit of values, and where little is at stake more of them are reversed. Verdicts (hp, hn) that differ from the draw
    are reversed; other claims pass. Christiano et al. (2017) scale to a constant standard deviation as well.
    """

    beta: Annotated[float, Range(0, 1e9)] = 1.0
    """The rationality: with 0 the verdict is a coin flip, with a large beta it follows the values."""
    scaled: bool = True
    """Whether to divide by the spread; if not, s is 1, as in B-Pref, and beta depends on the unit of values."""

    source = "B-Pref beta; Christiano et al. 2017"
    needs = frozenset(("hindsight", "values"))
    honest = False
    stage = _Odds


_LEAST = 1e-300  # where differences are so small that their squares are 0
