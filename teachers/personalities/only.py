"""only(kinds): a fixed subset of the kinds (LLF-Bench's feedback types that name kinds)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from teachers.atoms import FP, KINDS
from teachers.batches import Kinds, Moments, OracleBatch
from teachers.feedback import MIXED, number_of, parse_kinds
from teachers.personality import Claims, Personality, Stage, View
from worlds.batches import Floats


class _Filter(Stage["Only"]):
    """Filters by kind."""

    def begin(self) -> None:
        self._kinds = parse_kinds(self.spec.kinds)

    def speak(self, claims: Claims, view: View) -> Claims:
        return [claim for claim in claims if claim.kind in self._kinds]


@dataclass(frozen=True)
class Only(Personality):
    """Says claims of some kinds and withholds the others."""

    kinds: str = "r+hp+hn+fp+fn"
    """Kinds by code or by word, joined by `+`; words become codes."""

    source = "LLF-Bench's subsets"
    stage = _Filter

    def __post_init__(self) -> None:
        if not isinstance(self.kinds, str) or self.kinds == MIXED:
            raise ValueError(f"kinds must be names of kinds joined by '+', got {self.kinds!r}")
        parse_kinds(self.kinds)
        codes = {kind.word: kind.value for kind in KINDS}
        object.__setattr__(self, "kinds", "+".join(codes.get(name, name) for name in self.kinds.split("+")))

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """`_Filter.speak` in arrays."""
        return kinds & np.uint8(number_of(parse_kinds(self.kinds)))

    @property
    def reveals(self) -> bool:
        """Whether advice is among the kinds."""
        return FP in parse_kinds(self.kinds)
