"""myopic(gamma): blames an action only if another one solves the task sooner, within a horizon."""

from typing import Annotated

from teachers.atoms import HN
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="B-Pref gamma", needs=("hindsight", "plan", "values"))
def myopic(claims: Claims, view: View, *, gamma: Annotated[float, Range(0, 0.99)] = 0.9) -> Claims:
    """Values an action by gamma to the number of actions in which an optimal policy then solves the task.

    Beyond the horizon of 1 / (1 - gamma), 1 to 100 actions, the value is 0. It says blame (hn) only if another action
    has a greater value; an action without blame may still be worse in the long run. Other claims pass.
    """
    values = view.past_values()
    if values is None or not any(claim.kind is HN for claim in claims):
        return claims
    moment, horizon = view.moment, round(1 / (1 - gamma))
    mine = view.steps_to_success(moment.before, moment.action, horizon)
    # A better action needs fewer steps, so that the search can stop there.
    nearer = horizon if mine is None else mine - 1
    if any(view.steps_to_success(moment.before, action, nearer) for action in range(len(values))):
        return claims
    return [claim for claim in claims if claim.kind is not HN]
