"""harsh: says what was wrong, and nothing else."""

from teachers.atoms import HN
from teachers.personality import Claims, View, personality


@personality(reveals=False)
def harsh(claims: Claims, view: View) -> Claims:
    """Says blame (hn) only, and only true blame."""
    return [claim for claim in claims if claim.kind is HN]
