"""overconfident(by): says what it hedges with more confidence than it has."""

from typing import Annotated

from teachers.common import bend
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="the inverse of temperature scaling, Guo et al. 2017", honest=False)
def overconfident(claims: Claims, view: View, *, by: Annotated[float, Range(1, 100)] = 2.0) -> Claims:
    """Multiplies the log-odds of each hedge; by 2, 80 % becomes 94 %.

    A hedge has 99 % at most. Flat claims pass.
    """
    return [bend(claim, by) for claim in claims]
