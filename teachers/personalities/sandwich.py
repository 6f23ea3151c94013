"""sandwich: puts blame between praise and praise, or between praise and advice."""

from teachers.atoms import FN, FP, HN, HP, R
from teachers.personality import Claims, View, personality


@personality(source="folk")
def sandwich(claims: Claims, view: View) -> Claims:
    """Says the same claims in the order r, hp, hn, fn, fp; of several praises, the last follows the blame.

    It adds no praise: without praise it begins with the blame.
    """
    reward, praise, blame, warning, advice = ([c for c in claims if c.kind is kind] for kind in (R, HP, HN, FN, FP))
    last = praise[-1:] if len(praise) > 1 and blame else []
    return [*reward, *praise[: len(praise) - len(last)], *blame, *last, *warning, *advice]
