"""Oracles for many worlds at once, in arrays. A family's is in the module of its name."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from teachers.oracle import Oracle, RefusalError
from worlds.batches import Bools, Floats, Ints, StateT, WorldBatch, most

if TYPE_CHECKING:
    from teachers.personality import Claims, Stage

__all__ = ["Kinds", "Memory", "Moments", "OracleBatch", "Recall", "Said", "StageBatch", "subset"]

Kinds = npt.NDArray[np.uint8]
"""Subsets of the kinds, of shape (rows,): bit i for kind i."""
Memory = tuple[npt.NDArray[Any], ...]
"""A NamedTuple of arrays of shape (rows, ...), which are never changed in place."""
Recall = Callable[[int, int], "Claims"]
"""The claims about the moment of so many turns ago, of a subset of the kinds, in the form that the stage got them."""
S = TypeVar("S")


class Moments(NamedTuple, Generic[StateT]):
    """Moments in arrays, one row each; see `teachers.atoms.Moment`."""

    before: StateT
    """The worlds' state before the actions; undefined at an opening, where the turn is 0."""
    action: npt.NDArray[Any]
    reward: Floats
    after: StateT
    success: Bools
    turn: Ints
    over: Bools


class Said(NamedTuple):
    """What there is to say of moments, one row each."""

    kinds: Kinds
    """The kinds of the claims."""
    advised: npt.NDArray[Any]
    """The advised action (fp); undefined where there is none."""
    warned: npt.NDArray[Any]
    """The action of the warning (fn); undefined where there is none."""
    verdicts: npt.NDArray[Any] | None = None
    """Numbers of verdicts of kind hp and hn, of shape (rows, 2); None: one of each kind that is said."""
    judges: npt.NDArray[Any] | None = None
    """Whether hp and hn name the action, bool (rows, 2); None: they do."""


class OracleBatch(ABC, Generic[StateT]):
    """A family's oracle in arrays; of each kind it states at most one claim about an action.

    Args:
        oracle: an oracle for the worlds of the batch.
        worlds: the worlds that it judges.
    """

    def __init__(self, oracle: Oracle[Any, Any], worlds: WorldBatch[Any, StateT]) -> None:
        self.oracle, self.worlds = oracle, worlds

    @abstractmethod
    def judge(self, moments: Moments[StateT]) -> Said:
        """All claims that are true and worth saying, as `Oracle.judge`."""

    def values(self, state: StateT) -> Floats:
        """Value per discrete action, of shape (rows, actions), as `Oracle.values`; importance and regret follow."""
        raise RefusalError(f"{type(self).__name__} gives no values")

    def importance(self, state: StateT) -> Floats:
        """What is at stake in the next action, of shape (rows,), as `Oracle.importance`; by default from the values."""
        values = self.values(state)
        stake: Floats = most(values) + most(-values)
        return stake

    def plan_length(self, state: StateT, n: int) -> Ints:
        """The number of actions in `Oracle.plan`, of shape (rows,)."""
        raise RefusalError(f"{type(self).__name__} has no plan")


class StageBatch(ABC, Generic[S]):
    """A personality in arrays: a `teachers.personality.Stage` in each row, which withholds kinds of claims.

    Args:
        spec: the personality, for its parameters.
        oracle: the oracles of the rows.
        max_turns: turns after which an episode is truncated.
    """

    late = 0
    """Turns by which it delays what is said."""

    def __init__(self, spec: S, oracle: OracleBatch[Any], max_turns: int) -> None:
        self.spec, self.oracle = spec, oracle

    def blank(self, rows: int) -> Memory:
        """The memory of so many rows at the opening of an episode; its fields have the names of those of the stage."""
        return ()

    @abstractmethod
    def speak(self, kinds: Kinds, memory: Any, moments: Moments[Any]) -> tuple[Kinds, Memory]:
        """The kinds to say, and the memory afterwards; all arguments are of the same rows, once a turn.

        Args:
            kinds: those that the stage before left.
            memory: of the turns before.
            moments: the moments to speak of.
        """

    def remind(self, stage: "Stage[Any]", memory: Memory, row: int, turn: int, recall: Recall) -> None:
        """Copy the memory of a row into a stage in which `turn` turns have been played."""
        for name, array in zip(getattr(memory, "_fields", ()), memory, strict=True):
            setattr(stage, name, array[row].item())


def subset(r: Bools, hp: Bools, hn: Bools, fp: Bools, fn: Bools) -> Kinds:
    """The kinds that are true as bits, of shape (rows,): bit i for kind i."""
    total = np.zeros(len(r), np.uint8)
    for bit, said in enumerate((r, hp, hn, fp, fn)):
        total |= said.view(np.uint8) << np.uint8(bit)
    return total
