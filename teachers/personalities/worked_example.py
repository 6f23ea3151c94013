"""worked_example(n): shows the next optimal actions at once in place of advice."""

from typing import Annotated

from teachers.atoms import FP
from teachers.personality import Claims, View, personality
from teachers.spec import Range
from teachers.view import first_of


@personality(source="Shute 2008", needs=("advice", "plan"))
def worked_example(claims: Claims, view: View, *, n: Annotated[int, Range(1, 1000)] = 3) -> Claims:
    """Replaces advice (fp) by the next n actions of an optimal policy, up to the first that cannot be checked.

    If there is none, the advice passes.
    """
    at = first_of({FP}, claims)
    example = None if at is None else view.example(n)
    if example is None:
        return claims
    others = [claim for claim in claims[at:] if claim.kind is not FP]
    return [*claims[:at], example, *others]
