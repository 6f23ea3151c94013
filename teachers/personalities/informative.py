"""informative(bits): says the one true claim that says nearest to so many bits to the student."""

from typing import Annotated

from teachers.oracle import POSTERIOR
from teachers.personality import Claims, View, personality
from teachers.spec import Range, Worlds


@personality(needs=(POSTERIOR,))
def informative(
    claims: Claims, view: View, *, bits: Annotated[float, Range(0, 64)] = 1.0, worlds: Worlds = 256
) -> Claims:
    """Says the claim or clue whose information is nearest to `bits`, the first of equal ones.

    Worlds that the student cannot tell apart, by all that it has seen and heard, measure the information. Claims that
    the student can know already are withheld.
    """
    off = [(abs(found.bits - bits), claim) for claim, found in view.weigh_all(claims, worlds) if found.bits]
    return (min(off, key=lambda each: each[0])[1],) if off else ()
