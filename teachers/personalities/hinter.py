"""hinter(level): advises vaguely first (where to look, which way), and the action itself only if that did not help."""

from dataclasses import dataclass
from typing import Annotated

from teachers.atoms import FP
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range


class _Ladder(Stage["Hinter"]):
    """Keeps the rung of the ladder."""

    def begin(self) -> None:
        self._level = self.spec.level

    def speak(self, claims: Claims, view: View) -> Claims:
        right = view.right()
        if right is not None:
            self._level = self.spec.level if right else self._level + 1
        said = [view.coarsen(claim, self._level) if claim.kind is FP else claim for claim in claims]
        hints = [hint for hint, claim in zip(said, claims, strict=True) if hint is not claim]
        return [claim for claim in said if not any(view.gives_away(claim, hint) for hint in hints)]


@dataclass(frozen=True)
class Hinter(Personality):
    """Replaces advice (fp) by a coarser claim that follows from it; the rung of a ladder says which, the vaguest first.

    It climbs a rung after each bad action, and returns to rung `level` after a good one. On rung 0, advice without
    coarser claims becomes "there is something good to be done". It withholds what would make the hint an answer, such
    as a warning of one of two hinted ways.
    """

    level: Annotated[int, Range(0, 100)] = 0
    """The rung to begin with; 0 is the vaguest."""

    source = "Shute 2008"
    needs = frozenset(("advice", "hindsight", "hints"))
    stage = _Ladder
