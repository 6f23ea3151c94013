"""The regret of a turn, as stores, rollouts and training rewards count it."""

from typing import Any

from teachers.atoms import Moment
from teachers.oracle import Oracle, RefusalError

__all__ = ["turn_regret"]


def turn_regret(oracle: Oracle[Any, Any], moment: Moment[Any]) -> float:
    """The loss of value by the action of a turn, in the family's `regret_unit`; 0 at the opening.

    If the oracle has no values, it is the negated reward. An episode's sum then lacks the best possible return. This is
    unknown, but the same for all students and teachers in a world, so that their differences are differences of regret.
    """
    if not moment.turn:
        return 0.0
    try:
        return oracle.regret(moment)
    except RefusalError:
        return -moment.reward
