"""only(kinds): a fixed subset of the kinds (LLF-Bench's feedback types that name kinds)."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from teachers.atoms import FP, KINDS
from teachers.batches import Kinds, Memory, Moments, StageBatch
from teachers.feedback import MIXED, parse_kinds
from teachers.personality import Claims, Personality, Stage, View


class _Filter(Stage["Only"]):
    """Filters by kind."""

    def begin(self) -> None:
        self._kinds = parse_kinds(self.spec.kinds)

    def speak(self, claims: Claims, view: View) -> Claims:
        return [claim for claim in claims if claim.kind in self._kinds]


class _FilterBatch(StageBatch["Only"]):
    """Filters by kind."""

    def speak(self, kinds: Kinds, memory: Memory, moments: Moments[Any]) -> tuple[Kinds, Memory]:
        kept = parse_kinds(self.spec.kinds)
        return kinds & np.uint8(sum(1 << bit for bit, kind in enumerate(KINDS) if kind in kept)), memory


@dataclass(frozen=True)
class Only(Personality):
    """Says claims of some kinds and withholds the others."""

    kinds: str = "r+hp+hn+fp+fn"
    """Names of kinds, joined by `+`."""

    source = "LLF-Bench's subsets"
    stage, batch = _Filter, _FilterBatch

    def __post_init__(self) -> None:
        if not isinstance(self.kinds, str) or self.kinds == MIXED:
            raise ValueError(f"kinds must be names of kinds joined by '+', got {self.kinds!r}")
        parse_kinds(self.kinds)

    @property
    def reveals(self) -> bool:
        """Whether advice is among the kinds."""
        return FP in parse_kinds(self.kinds)
