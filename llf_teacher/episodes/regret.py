"""The regret of a turn, as stores, rollouts and training rewards count it."""

from typing import Any

from teachers.atoms import Moment
from teachers.oracle import Oracle, RefusalError

__all__ = ["turn_regret"]


def turn_regret(oracle: Oracle[Any, Any], moment: Moment[Any]) -> float:
    """Value that the action of a turn lost, in the family's `regret_unit`; 0 at the opening.

    Where the oracle has no values it is the negated reward. The sum of an episode then lacks what could be earned at
    best: a number that nobody knows, but the same for all students and teachers in the same world, so that their
    differences are those of regret.
    """
    if not moment.turn:
        return 0.0
    try:
        return oracle.regret(moment)
    except RefusalError:
        return -moment.reward
