"""mistake_correcting(budget, threshold): as importance, and only after an action that was not optimal."""

from dataclasses import dataclass

from teachers.personalities.importance import Importance, Weighing
from teachers.personality import View

TOLERANCE = 1e-9
"""Value that an optimal action may lose by rounding."""


class _Correcting(Weighing):
    """Counts the turns in which it speaks."""

    def wants(self, view: View) -> bool:
        acted = view.moment.action is not None
        return acted and view.past_importance() >= self.spec.threshold and view.regret() > TOLERANCE


@dataclass(frozen=True)
class MistakeCorrecting(Importance):
    """Speaks if much was at stake in the last action and it was not optimal; tied actions are all optimal.

    In the source the student announces its action and may be corrected before it acts; in our seats it has acted. A
    turn without an action is a mistake. Turns without a mistake cost no budget.
    """

    needs = frozenset(("importance", "regret"))
    stage = _Correcting
