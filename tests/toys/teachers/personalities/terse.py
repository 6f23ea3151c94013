"""terse: says only the first claim of each turn."""

from teachers.personality import Claims, View, personality


@personality(source="folk")
def terse(claims: Claims, view: View) -> Claims:
    """Says one thing at a time."""
    return claims[:1]
