"""informative(bits): says the one true claim that says nearest to so many bits to the student."""

from typing import Annotated

from teachers.oracle import POSTERIOR
from teachers.personality import Claims, View, personality
from teachers.spec import Range, Worlds


@personality(needs=(POSTERIOR,))
def informative(
    claims: Claims, view: View, *, bits: Annotated[float, Range(0, 64)] = 1.0, worlds: Worlds = 256
) -> Claims:
    """Of the claims and the oracle's clues, says the one nearest to so many bits; of equal ones, the first.

    Bits are measured by worlds that the student, which has seen and heard what it has, cannot tell apart. What it can
    know already, it is not told.
    """
    off = [(abs(found.bits - bits), claim) for claim, found in view.weigh_all(claims, worlds) if found.bits]
    return (min(off, key=lambda each: each[0])[1],) if off else ()
