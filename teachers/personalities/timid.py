"""timid(by): says what it hedges with less confidence than it has."""

from typing import Annotated

from teachers.common import bend
from teachers.personality import Claims, View, personality
from teachers.spec import Range


@personality(source="temperature scaling, Guo et al. 2017")
def timid(claims: Claims, view: View, *, by: Annotated[float, Range(1, 100)] = 2.0) -> Claims:
    """Divides the log-odds of each hedge; by 2, 80 % becomes 67 %.

    A hedge has 51 % at least. Flat claims pass.
    """
    return [bend(claim, 1 / by) for claim in claims]
