"""importance(budget, threshold): speaks in states in which much is at stake, while the budget lasts."""

from dataclasses import dataclass
from typing import Annotated, Any

from teachers.batches import Kinds, Moments, OracleBatch
from teachers.personalities.early import Advising, Early
from teachers.personality import View
from teachers.spec import Range
from worlds.batches import Floats


class Weighing(Advising["Importance"]):
    """Counts the turns in which it speaks."""

    def wants(self, view: View) -> bool:
        """Whether much is at stake in the next action."""
        return not view.moment.over and view.importance() >= self.spec.threshold


@dataclass(frozen=True)
class Importance(Early):
    """Speaks if the best action is worth at least the threshold more than the worst, and budget is left.

    The budget counts the turns of an episode in which it speaks; the threshold is in units of the oracle's values.
    """

    threshold: Annotated[float, Range(0, 1e9)] = 0.5
    """Least importance, at least 0."""

    needs = frozenset(("importance",))
    stage = Weighing

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """`Weighing.speak` in arrays."""
        wants = ~moments.over & (oracle.stakes(moments.after).importance >= self.threshold)
        return super().speak_rows(kinds * wants, memory, moments, oracle)
