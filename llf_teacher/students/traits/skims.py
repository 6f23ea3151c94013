"""skims(kinds, p): skips sentences of some kinds."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.scene import HeardBatch, Scene, SceneBatch
from llf_teacher.students.trait import Trait
from teachers.atoms import KINDS, Atom, Claim
from teachers.feedback import BIT, format_kinds, parse_kinds
from teachers.spec import Share


@dataclass(frozen=True)
class Skims(Trait):
    """With probability p skips a claim of one of the kinds, as if it had not been said."""

    kinds: str = "fp"
    """The kinds that it skips, such as `fp` or `hp+hn`; `a`: all."""
    p: Share = 1.0
    """The probability, independent for each claim, 0 to 1; 0: never."""
    strength = "p"

    def __post_init__(self) -> None:
        super().__post_init__()
        if not parse_kinds(self.kinds):
            raise ValueError(f"kinds must name kinds of feedback, such as 'fp' or 'hp+hn', got {self.kinds!r}")
        object.__setattr__(self, "kinds", format_kinds(self.kinds))

    def hear(self, atom: Atom, scene: Scene) -> Claim[Any] | None:
        """The claim, or nothing."""
        skipped = atom.kind in parse_kinds(self.kinds) and scene.happens(self.p)
        return None if skipped else atom.claim

    def hear_rows(self, heard: HeardBatch, scene: SceneBatch) -> HeardBatch:
        """`hear` in arrays."""
        kinds = heard.kinds
        for kind in KINDS:
            if kind in parse_kinds(self.kinds):
                kinds = kinds - BIT[kind] * scene.happens(self.p, heard.kinds & BIT[kind] > 0)
        return heard._replace(kinds=kinds)
