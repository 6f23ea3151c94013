"""oracle: says every true claim of the wanted kinds (LLF-Bench's feedback type `a`)."""

from teachers.personality import Claims, View, personality


@personality(source="LLF-Bench's `a`", transparent=True)
def oracle(claims: Claims, view: View) -> Claims:
    """Passes on every claim."""
    return claims
