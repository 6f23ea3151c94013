"""elaborator: right or wrong, and why."""

from teachers.common import Late
from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT, first_of


@personality(source="Shute 2008", needs=("hindsight",))
def elaborator(claims: Claims, view: View) -> Claims:
    """Says "right" or "wrong" as `verification` does, then the reasons: all praise and blame. Other claims pass.

    It omits the verdict if it is among the claims already, or if a claim about this turn contradicts it.
    """
    at = first_of(HINDSIGHT, claims)
    verdict = None if at is None else view.verdict()
    now = [claim for claim in claims if not isinstance(claim, Late)]
    if verdict is None or any(verdict == c or verdict.excludes(c) or c.excludes(verdict) for c in now):
        return claims
    return [*claims[:at], verdict, *claims[at:]]
