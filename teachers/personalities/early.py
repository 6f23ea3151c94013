"""early(budget): speaks in the first turns and is silent from then on (early advising)."""

from dataclasses import dataclass
from typing import Any, TypeVar

from teachers.batches import Kinds, Moments, OracleBatch
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Count
from worlds.batches import Floats

E = TypeVar("E", bound="Early")


class Advising(Stage[E]):
    """Counts the turns in which it speaks."""

    def begin(self) -> None:
        """Start with the whole budget."""
        self._left = self.spec.budget

    def speak(self, claims: Claims, view: View) -> Claims:
        """All claims in turns that `wants` selects, while the budget lasts."""
        if not claims or not self._left or not self.wants(view):
            return ()
        self._left -= 1
        return claims

    def wants(self, view: View) -> bool:
        """Whether to spend the budget on this turn."""
        return True


@dataclass(frozen=True)
class Early(Personality):
    """Spends its budget as soon as it can. The budget counts the turns of an episode in which it speaks."""

    budget: Count = 10
    """Turns in which it may speak, at least 0."""

    source = "Torrey & Taylor 2013"
    stage = Advising
    row_memory = 1

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """`Advising.speak` in arrays, for all turns. The memory holds the spent budget."""
        speaks = (kinds > 0) & (memory[:, 0] < self.budget)
        memory[:, 0] += speaks
        return kinds * speaks
