"""encouraging: begins with what was good."""

from teachers.atoms import HP
from teachers.personality import Claims, View, personality


@personality()
def encouraging(claims: Claims, view: View) -> Claims:
    """Says the same claims, praise (hp) first."""
    return sorted(claims, key=lambda claim: claim.kind is not HP)
