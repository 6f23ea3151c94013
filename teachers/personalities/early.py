"""early(budget): speaks in the first turns and is silent from then on (early advising)."""

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from teachers.batches import Kinds, Moments, StageBatch
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Count
from worlds.batches import Bools, Ints

E = TypeVar("E", bound="Early")


class Advising(Stage[E]):
    """Counts the turns in which something is said."""

    def begin(self) -> None:
        """Start with the whole budget."""
        self.left = self.spec.budget

    def speak(self, claims: Claims, view: View) -> Claims:
        """All claims in turns that are worth it, while the budget lasts."""
        if not claims or not self.left or not self.wants(view):
            return ()
        self.left -= 1
        return claims

    def wants(self, view: View) -> bool:
        """Whether this turn is worth a turn of the budget."""
        return True


class _Left(NamedTuple):
    left: Ints
    """Turns that are left of the budget, of shape (rows,)."""


class AdvisingBatch(StageBatch[E]):
    """`Advising` in arrays."""

    def blank(self, rows: int) -> _Left:
        """The whole budget."""
        return _Left(np.full(rows, self.spec.budget))

    def speak(self, kinds: Kinds, memory: _Left, moments: Moments[Any]) -> tuple[Kinds, _Left]:
        """All kinds in turns that are worth it, while the budget lasts."""
        speaks = (kinds > 0) & (memory.left > 0) & self.wants(moments)
        return kinds * speaks, _Left(memory.left - speaks)

    def wants(self, moments: Moments[Any]) -> Bools:
        """Whether these turns are worth a turn of the budget, of shape (rows,)."""
        return np.ones(len(moments.turn), bool)


@dataclass(frozen=True)
class Early(Personality):
    """Spends its budget as soon as it can. The budget counts turns of an episode in which something is said."""

    budget: Count = 10
    """Turns in which it may speak, at least 0."""

    source = "Torrey & Taylor 2013"
    stage, batch = Advising, AdvisingBatch
