"""What oracles say of many worlds at once, in arrays. A family's is in the module of its name."""

from abc import ABC, abstractmethod
from typing import Any, Generic, NamedTuple

import numpy as np
import numpy.typing as npt

from teachers.oracle import Oracle, RefusalError
from worlds.batches import Bools, Floats, Ints, StateT, WorldBatch

__all__ = ["Moments", "OracleBatch", "Said", "subset"]


class Moments(NamedTuple, Generic[StateT]):
    """Turns as teachers see them, a row each: `teachers.atoms.Moment` in arrays."""

    before: StateT
    """The worlds' state before the actions; that of an opening, whose turn is 0, has no meaning."""
    action: npt.NDArray[Any]
    reward: Floats
    after: StateT
    success: Bools
    turn: Ints
    over: Bools


class Said(NamedTuple):
    """What there is to say of a moment, a row each."""

    kinds: npt.NDArray[np.uint8]
    """The kinds of the claims, as a subset's number: bit i for kind i."""
    advised: npt.NDArray[Any]
    """The action that is advised (fp); without meaning where none is."""
    warned: npt.NDArray[Any]
    """The action that is warned of (fn); without meaning where none is."""


class OracleBatch(ABC, Generic[StateT]):
    """States in arrays what a family's oracle states claims of; of one kind there is at most one about an action.

    Args:
        oracle: one for the worlds of the batch.
        worlds: what it looks at.
    """

    def __init__(self, oracle: Oracle[Any, Any], worlds: WorldBatch[Any, StateT]) -> None:
        self.oracle, self.worlds = oracle, worlds

    @abstractmethod
    def judge(self, moments: Moments[StateT]) -> Said:
        """All that is true and worth saying: `Oracle.judge`."""

    def values(self, state: StateT) -> Floats:
        """Value per discrete action, of shape (rows, actions): `Oracle.values`; importance and regret follow."""
        raise RefusalError(f"{type(self).__name__} gives no values")

    def way(self, state: StateT, n: int) -> Ints:
        """How many actions `Oracle.plan` has."""
        raise RefusalError(f"{type(self).__name__} plans nothing")


def subset(r: Bools, hp: Bools, hn: Bools, fp: Bools, fn: Bools) -> npt.NDArray[np.uint8]:
    """The number of the subset of kinds that are true, a row each."""
    total = np.zeros(len(r), np.uint8)
    for bit, said in enumerate((r, hp, hn, fp, fn)):
        total |= said.view(np.uint8) << np.uint8(bit)
    return total
