"""importance(budget, threshold): speaks in states in which much is at stake, while the budget lasts."""

from dataclasses import dataclass
from typing import Annotated, Any

from teachers.batches import Moments
from teachers.personalities.early import Advising, AdvisingBatch, Early
from teachers.personality import View
from teachers.spec import Range
from worlds.batches import Bools


class Weighing(Advising["Importance"]):
    """Counts the turns in which something is said."""

    def wants(self, view: View) -> bool:
        """Whether much is at stake in the next action."""
        return not view.moment.over and view.importance() >= self.spec.threshold


class _WeighingBatch(AdvisingBatch["Importance"]):
    """`Weighing` in arrays."""

    def wants(self, moments: Moments[Any]) -> Bools:
        """Whether much is at stake in the next actions."""
        return ~moments.over & (self.oracle.importance(moments.after) >= self.spec.threshold)


@dataclass(frozen=True)
class Importance(Early):
    """Speaks iff the best action is worth at least the threshold more than the worst, and budget is left.

    The budget counts turns of an episode in which something is said; the threshold is in units of the oracle's values.
    """

    threshold: Annotated[float, Range(0, 1e9)] = 0.5
    """Least importance, at least 0."""

    needs = frozenset(("importance",))
    stage, batch = Weighing, _WeighingBatch
