"""sandwich: puts blame between praise and praise, or between praise and advice."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import FN, FP, HN, HP, Claim, R
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Sandwich(Personality):
    """Says the same claims in the order r, hp, hn, fn, fp, with the last praise, if there is more, behind the blame.

    It invents no praise: where there is none, it begins with the blame.
    """

    source = "folk"

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """The claims in another order."""
            reward, praise, blame, warning, advice = ([c for c in claims if c.kind is kind] for kind in _ORDER)
            last = praise[-1:] if len(praise) > 1 and blame else []
            return [*reward, *praise[: len(praise) - len(last)], *blame, *last, *warning, *advice]


_ORDER = (R, HP, HN, FN, FP)
