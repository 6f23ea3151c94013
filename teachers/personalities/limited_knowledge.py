"""limited_knowledge(fraction): knows only part of the states, and is silent about the others."""

from dataclasses import dataclass

from teachers.atoms import R
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share


class _Knowledge(Stage["LimitedKnowledge"]):
    """Knows the states whose fingerprints, as shares of a circle, lie in an arc."""

    def begin(self) -> None:
        self._start = float(self.rng.random())

    def speak(self, claims: Claims, view: View) -> Claims:
        known, start = self.spec.fraction, self._start
        return [
            claim for claim in claims if claim.kind is R or (view.share(view.state_of(claim)) - start) % 1.0 < known
        ]


@dataclass(frozen=True)
class LimitedKnowledge(Personality):
    """Says a claim iff it knows the state in which the action was or will be taken that the claim is about.

    Which states it knows is drawn when an episode begins. Rewards (r) are there for everybody to see.
    """

    fraction: Share = 0.5
    """Share of the states that it knows, 0 to 1."""

    source = "Bignold et al. 2021; Fachantidis et al. 2019"
    stage = _Knowledge
