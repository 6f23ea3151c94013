"""myopic(gamma): sees no farther than its horizon, and has no objection to what does no harm within it."""

from collections.abc import Sequence
from dataclasses import dataclass

from teachers.atoms import HN, Claim
from teachers.personality import Personality, Stage, View
from teachers.spec import check_range


@dataclass(frozen=True)
class Myopic(Personality):
    """Judges an action by how soon an optimal policy solves the task after it: gamma to the number of actions.

    What lies behind the horizon of 1 / (1 - gamma) actions counts 0. Blame (hn) is said only if another action is worth
    more so; to a far-sighted teacher it may be deserved all the same. Other claims pass.
    """

    gamma: float = 0.9
    """Discount, 0 to 0.99; the horizon is 1 to 100 actions."""

    source = "B-Pref gamma"
    needs = frozenset(("hindsight", "plan", "values"))

    def __post_init__(self) -> None:
        check_range("gamma", self.gamma, 0, 0.99)

    class Stage(Stage):
        """Has nothing to remember."""

        def speak(self, claims: tuple[Claim, ...], view: View) -> Sequence[Claim]:
            """Everything but the blame that it does not see."""
            values = view.past_values()
            if values is None or not any(claim.kind is HN for claim in claims):
                return claims
            moment, horizon = view.moment, round(1 / (1 - self.spec.gamma))
            mine = view.soonest(moment.before, moment.action, horizon)
            # Whatever is sooner than this action needs fewer steps, so that nobody has to look farther.
            nearer = horizon if mine is None else mine - 1
            if any(view.soonest(moment.before, action, nearer) for action in range(len(values))):
                return claims
            return [claim for claim in claims if claim.kind is not HN]
