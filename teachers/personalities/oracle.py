"""oracle: says every true claim of the wanted kinds (LLF-Bench's feedback type `a`)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Oracle(Personality):
    """Passes every claim on."""

    source = "LLF-Bench's `a`"

    class Stage(Stage):
        """Adds nothing, withholds nothing."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """All of it."""
            return claims

    @property
    def transparent(self) -> bool:
        """Always."""
        return True
