"""comparing: says only which of two actions is better now, and which of two turns was."""

from typing import Any

from teachers.atoms import FP, Claim
from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT, first_of


@personality(needs=("values", "advice", "hindsight"))
def comparing(claims: Claims, view: View) -> Claims:
    """Compares in place of verdicts and advice, and withholds all else.

    The last turn is compared with the latest earlier one that lost more or less. A best action is compared with the
    student's last one, if that loses something now; else, and at the opening, with the best of those that do.
    """
    said: list[Claim[Any]] = []
    if first_of(HINDSIGHT, claims) is not None:
        turns = (view.better_turn(ago) for ago in range(1, view.turn))
        said += [claim for claim in turns if claim is not None][:1]
    values, plan = view.values(), view.plan(1)
    if first_of({FP}, claims) is not None and not view.moment.over and values is not None and plan:
        worse = [action for action, value in enumerate(values) if max(values) - value > 1e-9]
        last = view.moment.action
        other = last if last in worse else max(worse, key=lambda action: values[action])
        said += [claim for claim in (view.better(plan[0], other),) if claim is not None]
    return said
