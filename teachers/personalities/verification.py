"""verification: right or wrong, and no reason."""

from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT


@personality(source="Shute 2008", needs=("hindsight",), reveals=False)
def verification(claims: Claims, view: View) -> Claims:
    """Says nothing but "right" if there is something good to say of the last action and nothing bad, else "wrong".

    It is silent if no verdict would have been said.
    """
    verdict = view.verdict() if any(claim.kind in HINDSIGHT for claim in claims) else None
    return () if verdict is None else (verdict,)
