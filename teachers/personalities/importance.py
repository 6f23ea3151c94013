"""importance(budget, threshold): speaks in states in which much is at stake, while the budget lasts."""

from dataclasses import dataclass

from teachers.personalities import early
from teachers.personality import Personality, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Importance(Personality):
    """Speaks iff the best action is worth more than the worst by the threshold, and there is budget left.

    The budget counts turns of an episode in which something is said; the threshold is in units of the oracle's values.
    """

    budget: int = 10
    """Turns in which it may speak, at least 0."""
    threshold: float = 0.5
    """Least importance of the next action, at least 0."""

    source = "Torrey & Taylor 2013"
    needs = frozenset(("importance",))

    def __post_init__(self) -> None:
        check_range("budget", self.budget, 0, 1_000_000, int)
        check_range("threshold", self.threshold, 0, 1e9)

    class Stage(early.Early.Stage):
        """Counts turns of advice."""

        def wants(self, view: View) -> bool:
            """Whether much is at stake in the next action."""
            return not view.moment.over and view.importance() >= self.spec.threshold
