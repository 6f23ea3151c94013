"""verification: right or wrong, and no reason."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.view import HINDSIGHT


@dataclass(frozen=True)
class Verification(Personality):
    """Says "right" if there is something good and nothing bad to say of the last action, "wrong" if there is something
    bad, and nothing else.
    """  # noqa: D205

    source = "Shute 2008"
    needs = frozenset(("hindsight",))
    reveals = False

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The one word, if any verdict would have been said."""
            verdict = view.verdict() if any(claim.kind in HINDSIGHT for claim in claims) else None
            return () if verdict is None else (verdict,)
