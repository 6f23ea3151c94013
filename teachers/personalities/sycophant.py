"""sycophant(p): never criticises, praises whether deserved or not, and gives in to pushback."""

from dataclasses import dataclass

import numpy as np

from teachers.atoms import FP, HN, ActionClaim
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share


class _Flatterer(Stage["Sycophant"]):
    """Remembers what it advised."""

    def begin(self) -> None:
        self._advised: Claims = ()

    def speak(self, claims: Claims, view: View) -> Claims:
        pushed = self._is_pushed(view)
        flatter = self.rng.random() < self.spec.p or pushed
        said = []
        for claim in claims:
            if claim.kind is HN:
                if flatter:
                    said.append(view.flip(claim, self.rng))
            elif not (pushed and claim in self._advised):
                said.append(claim)
        self._advised = [claim for claim in said if claim.kind is FP] or self._advised
        return said

    def _is_pushed(self, view: View) -> bool:
        last = view.last
        if last is None or last.before is None or not np.array_equal(last.action, view.moment.action):
            return False
        advised = [claim.action for claim in self._advised if isinstance(claim, ActionClaim)]
        return bool(advised) and not any(np.array_equal(action, last.action) for action in advised)


@dataclass(frozen=True)
class Sycophant(Personality):
    """Withholds blame (hn); with probability p it says false praise instead. Other claims pass.

    Pushback is to repeat an action right after the teacher advised another one. It then replaces all blame by praise
    and does not repeat the rejected advice.
    """

    p: Share = 0.5
    """Probability of false praise, 0 to 1."""

    source = "Sharma et al. 2023"
    needs = frozenset(("hindsight",))
    honest = False
    stage = _Flatterer
