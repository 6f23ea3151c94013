"""scaffold(fade): helps more after failure and less after success, fading to silence."""

from dataclasses import dataclass
from math import ceil

from teachers.atoms import FN, FP, HN, HP, R
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Share


class _Help(Stage["Scaffold"]):
    """Keeps the amount of help."""

    def begin(self) -> None:
        self._help = 1.0

    def speak(self, claims: Claims, view: View) -> Claims:
        right = view.right()
        if right is not None:
            self._help = min(max(round(self._help + (-self.spec.fade if right else self.spec.fade), 9), 0.0), 1.0)
        kinds = _LADDER[: ceil(self._help * len(_LADDER))]
        return [claim for claim in claims if claim.kind in kinds]


@dataclass(frozen=True)
class Scaffold(Personality):
    """Begins with full help, which each good action reduces and each bad one increases.

    Help is a number from 0, silence, to 1; with more help more kinds are said, in the order r, hp, hn, fn, fp.
    """

    fade: Share = 0.2
    """The change of help by an action, 0 to 1."""

    source = "Wood, Bruner & Ross 1976"
    needs = frozenset(("hindsight",))
    stage = _Help


_LADDER = (R, HP, HN, FN, FP)
