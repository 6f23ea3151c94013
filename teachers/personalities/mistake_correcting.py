"""mistake_correcting(budget, threshold): as importance, and only after an action that was not optimal."""

from dataclasses import dataclass

from teachers.personalities import importance
from teachers.personality import Personality, View


@dataclass(frozen=True)
class MistakeCorrecting(Personality):
    """Speaks iff much was at stake in the last action and it was not optimal; tied actions are all optimal.

    In the source the student announces its action and may be corrected before it acts; in our seats it has acted. A
    turn without an action is a mistake. Finding out that there was one costs no budget, as in `importance`.
    """

    budget: int = 10
    """Turns in which it may speak, at least 0."""
    threshold: float = 0.5
    """Least importance that the last action had, at least 0."""

    source = "Torrey & Taylor 2013"
    needs = frozenset(("importance", "regret"))

    __post_init__ = importance.Importance.__post_init__

    class Stage(importance.Importance.Stage):
        """Counts turns of advice."""

        def wants(self, view: View) -> bool:
            """Whether the last action was a mistake that matters."""
            acted = view.moment.action is not None
            return acted and view.past_importance() >= self.spec.threshold and view.regret() > TOLERANCE


TOLERANCE = 1e-9
"""Value that an optimal action may lose, for rounding."""
