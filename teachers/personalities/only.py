"""only(kinds): a fixed subset of the kinds (LLF-Bench's feedback types that name kinds)."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import FP, Claim
from teachers.feedback import MIXED, parse_kinds
from teachers.personality import Personality, Stage, View


@dataclass(frozen=True)
class Only(Personality):
    """Says claims of some kinds and withholds the others."""

    kinds: str = "r+hp+hn+fp+fn"
    """Names of kinds, joined by `+`."""

    source = "LLF-Bench's subsets"

    def __post_init__(self) -> None:
        if not isinstance(self.kinds, str) or self.kinds == MIXED:
            raise ValueError(f"kinds must be names of kinds joined by '+', got {self.kinds!r}")
        parse_kinds(self.kinds)

    @property
    def reveals(self) -> bool:  # type: ignore[override]
        """Whether advice is among the kinds."""
        return FP in parse_kinds(self.kinds)

    class Stage(Stage):
        """Filters by kind."""

        def begin(self) -> None:
            """Parse once."""
            self._kinds = parse_kinds(self.spec.kinds)

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Those of the kinds."""
            return [claim for claim in claims if claim.kind in self._kinds]
