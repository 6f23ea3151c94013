"""comparing: says only which of two actions is better now, and which of two turns was."""

from typing import Any

from teachers.atoms import FP, Claim
from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT, first_of


@personality(needs=("plan", "advice", "hindsight"))
def comparing(claims: Claims, view: View) -> Claims:
    """Compares in place of verdicts and advice, and withholds all else.

    The last turn is compared with the latest earlier one that lost more or less. A best action is compared with the
    student's last one, if that loses something now; else, and at the opening, with the best of those that do. Where
    actions have no values, turns are not compared, and actions only with the student's last one.
    """
    said: list[Claim[Any]] = []
    if first_of(HINDSIGHT, claims) is not None:
        turns = (view.better_turn(ago) for ago in range(1, view.turn))
        said += [claim for claim in turns if claim is not None][:1]
    plan, last = view.plan(1), view.moment.action
    if first_of({FP}, claims) is not None and not view.moment.over and plan:
        values = view.values()
        if values is not None:
            worse = [action for action, value in enumerate(values) if max(values) - value > 1e-9]
            last = last if last in worse else max(worse, key=lambda action: values[action])
        elif view.moment.before is None:
            return said
        claim = view.better(plan[0], last)
        said += [claim] if claim is not None and view.holds(claim) else []
    return said
