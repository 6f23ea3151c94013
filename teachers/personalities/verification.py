"""verification: right or wrong, and no reason."""

from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT


@personality(source="Shute 2008", needs=("hindsight",), reveals=False)
def verification(claims: Claims, view: View) -> Claims:
    """Says only "right" if all hindsight on the last action is praise, else only "wrong".

    It is silent where it gets no verdict.
    """
    verdict = view.verdict() if any(claim.kind in HINDSIGHT for claim in claims) else None
    return () if verdict is None else (verdict,)
