"""mix: a random non-empty subset of the kinds, drawn anew each turn (LLF-Bench's feedback type `m`)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.feedback import draw_kinds
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Mix(Personality):
    """Each non-empty subset of the wanted kinds is equally likely; a turn without claims of these kinds is silent."""

    source = "LLF-Bench's `m`"

    class Stage(Stage):
        """Draws a subset a turn."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Those of the drawn kinds."""
            kinds = draw_kinds(view.kinds, self.rng)
            return [claim for claim in claims if claim.kind in kinds]
