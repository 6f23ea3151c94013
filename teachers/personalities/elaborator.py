"""elaborator: right or wrong, and why."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import Claim
from teachers.personality import Personality, Stage, View
from teachers.view import HINDSIGHT


@dataclass(frozen=True)
class Elaborator(Personality):
    """Says "right" or "wrong" as `verification` does, and then the reasons: all praise and blame. Other claims pass."""

    source = "Shute 2008"
    needs = frozenset(("hindsight",))

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The word before the first reason."""
            at = next((i for i, claim in enumerate(claims) if claim.kind in HINDSIGHT), None)
            verdict = None if at is None else view.verdict()
            return claims if verdict is None else [*claims[:at], verdict, *claims[at:]]
