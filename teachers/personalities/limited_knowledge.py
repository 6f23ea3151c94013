"""limited_knowledge(fraction): speaks only of a part of the states."""

from dataclasses import dataclass

from teachers.atoms import R
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share


class _Knowledge(Stage["LimitedKnowledge"]):
    """Keeps the arc in which the fingerprints of known states lie, as shares of a circle."""

    def begin(self) -> None:
        self._start = float(self.rng.random())

    def speak(self, claims: Claims, view: View) -> Claims:
        known, start = self.spec.fraction, self._start
        return [
            claim for claim in claims if claim.kind is R or (view.share(view.state_of(claim)) - start) % 1.0 < known
        ]


@dataclass(frozen=True)
class LimitedKnowledge(Personality):
    """Says a claim if it knows the state before the action that the claim is about.

    The known states are drawn at the start of each episode. Rewards (r) are always said.
    """

    fraction: Share = 0.5
    """Share of the states that are known, 0 to 1."""

    source = "Bignold et al. 2021; Fachantidis et al. 2019"
    stage = _Knowledge
