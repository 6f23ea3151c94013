"""noisy(beta): judges by chance, the more surely the more an action's value differs from its rival's."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HP, Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range
from teachers.view import HINDSIGHT


@dataclass(frozen=True)
class Noisy(Personality):
    """Calls the last action good with the probability that Bradley and Terry's model gives it over its rival.

    That is 1 / (1 + exp(-beta (v - w))) with v the action's value and w the greatest of those that differ from it; an
    action without such a rival is good. Verdicts (hp, hn) are turned round where the draw says otherwise; other claims
    pass.
    """

    beta: float = 1.0
    """Rationality, at least 0: 0 judges by a coin, a great one by the values."""

    source = "B-Pref beta"
    needs = frozenset(("hindsight", "values"))
    honest = False

    def __post_init__(self) -> None:
        check_range("beta", self.beta, 0, 1e9)

    class Stage(Stage):
        """Draws once a turn."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Verdicts as they were drawn."""
            draw, values = self.rng.random(), view.past_values()
            if values is None:
                return claims
            value = values[view.moment.action]
            rivals = [other for other in values if other != value]
            margin = self.spec.beta * (value - max(rivals)) if rivals else math.inf
            good = draw < (1 / (1 + math.exp(-margin)) if margin > -700 else 0.0)
            return [
                view.flip(claim, self.rng) if claim.kind in HINDSIGHT and (claim.kind is HP) != good else claim
                for claim in claims
            ]
