"""verification: right or wrong, and no reason."""

from teachers.personality import Claims, View, personality
from teachers.view import HINDSIGHT, first_of


@personality(source="Shute 2008", needs=("hindsight",), reveals=False)
def verification(claims: Claims, view: View) -> Claims:
    """Says only "right" if all hindsight on the last action is praise, else only "wrong".

    It is silent where it gets no verdict.
    """
    verdict = None if first_of(HINDSIGHT, claims) is None else view.verdict()
    return () if verdict is None else (verdict,)
