"""silent: says nothing but the instruction (LLF-Bench's feedback type `n`)."""

from teachers.personality import Claims, View, personality


@personality(source="LLF-Bench's `n`", reveals=False, mute=True)
def silent(claims: Claims, view: View) -> Claims:
    """Withholds everything."""
    return ()
