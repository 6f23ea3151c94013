"""silent: says nothing but the instruction (LLF-Bench's feedback type `n`)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Silent(Personality):
    """Withholds everything."""

    source = "LLF-Bench's `n`"
    reveals = False

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Nothing."""
            return ()
