"""Terse: says only the first claim of each turn."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Terse(Personality):
    """Says one thing at a time."""

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The first claim."""
            return claims[:1]
