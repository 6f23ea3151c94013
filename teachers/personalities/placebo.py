"""placebo: true but useless text, matched in length to what the oracle would have said.

A control: it measures the gain from hearing any text at all (arXiv 2606.30774).
"""

from dataclasses import dataclass

from teachers.atoms import R
from teachers.common import FACTS, Truism
from teachers.personality import Claims, Personality, Stage, View


class _Truisms(Stage["Placebo"]):
    """Counts by how many words it is behind the oracle."""

    def begin(self) -> None:
        self._owed = 0.0
        self._lengths: list[tuple[str, float]] = []

    def speak(self, claims: Claims, view: View) -> Claims:
        if claims and not self._lengths:
            self._lengths = [(fact, view.words(Truism(kind=R, fact=fact))) for fact in FACTS]
        said = []
        for claim in claims:
            self._owed += view.words(claim)
            nearest = sorted(self._lengths, key=lambda each: abs(each[1] - self._owed))
            fact, words = nearest[self.rng.integers(2)]  # so that sentences vary
            self._owed -= words
            said.append(Truism(kind=claim.kind, fact=fact))
        return said


@dataclass(frozen=True)
class Placebo(Personality):
    """Replaces each claim by a truism of the same kind and, on average over a few turns, the same length."""

    source = "arXiv 2606.30774"
    reveals = False
    stage = _Truisms
