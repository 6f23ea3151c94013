"""harsh: says what was wrong, and nothing else."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HN, Claim
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Harsh(Personality):
    """Says blame (hn) only; it is deserved."""

    reveals = False

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The blame."""
            return [claim for claim in claims if claim.kind is HN]
