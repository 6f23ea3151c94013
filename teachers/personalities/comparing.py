"""comparing: says only which of two actions is better now, and which of two turns was."""

from typing import Any

from teachers.atoms import FP, Claim
from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT, first_of


@personality(needs=("plan", "advice", "hindsight"))
def comparing(claims: Claims, view: View) -> Claims:
    """Says comparisons in place of verdicts and advice, and withholds all other claims.

    It compares the last turn with the latest earlier turn that lost more or less. It compares a best action with the
    student's last one if that loses value now; else, and at the opening, with the best action that loses value. If
    actions have no values, it does not compare turns, and it compares actions only with the student's last one. What
    it compares are actions with numbers as it says them, to four significant digits.
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
        claim = view.better(*map(view.as_said, (plan[0], last)))
        said += [claim] if claim is not None and view.clearly(claim) and view.holds(claim) else []
    return said
