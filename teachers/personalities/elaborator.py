"""elaborator: right or wrong, and why."""

from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT


@personality(source="Shute 2008", needs=("hindsight",))
def elaborator(claims: Claims, view: View) -> Claims:
    """Says "right" or "wrong" as `verification` does, then the reasons: all praise and blame. Other claims pass."""
    at = next((i for i, claim in enumerate(claims) if claim.kind in HINDSIGHT), None)
    verdict = None if at is None else view.verdict()
    return claims if verdict is None else [*claims[:at], verdict, *claims[at:]]
