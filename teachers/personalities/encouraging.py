"""encouraging: begins with what was good."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HP, Claim
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Encouraging(Personality):
    """Says the same claims, praise (hp) first; the truth stays the same."""

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The claims in another order."""
            return sorted(claims, key=lambda claim: claim.kind is not HP)
