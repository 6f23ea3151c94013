"""myopic(gamma): sees no farther than its horizon, and has no objection to what does no harm within it."""

from typing import Annotated

from teachers.atoms import HN
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="B-Pref gamma", needs=("hindsight", "plan", "values"))
def myopic(claims: Claims, view: View, *, gamma: Annotated[float, Range(0, 0.99)] = 0.9) -> Claims:
    """Judges an action by how soon an optimal policy solves the task after it: gamma to the number of actions.

    What lies behind the horizon of 1 / (1 - gamma), 1 to 100 actions, counts 0. Blame (hn) is said only if another
    action is worth more so; to a far-sighted teacher it may be deserved all the same. Other claims pass.
    """
    values = view.past_values()
    if values is None or not any(claim.kind is HN for claim in claims):
        return claims
    moment, horizon = view.moment, round(1 / (1 - gamma))
    mine = view.soonest(moment.before, moment.action, horizon)
    # Whatever is sooner than this action needs fewer steps, so that nobody has to look farther.
    nearer = horizon if mine is None else mine - 1
    if any(view.soonest(moment.before, action, nearer) for action in range(len(values))):
        return claims
    return [claim for claim in claims if claim.kind is not HN]
