"""Batches: many worlds of the same class and options in arrays, one per row. Each family has a module of its name."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from itertools import islice
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from worlds.batches.streams import ALL, Bools, Floats, Ints, Rows, Streams
from worlds.world import TruthT, World

__all__ = [
    "ALL",
    "Bools",
    "Floats",
    "Ints",
    "Outcome",
    "Rows",
    "StateT",
    "WorldBatch",
    "chosen",
    "merged",
    "most",
    "without",
]

StateT = TypeVar("StateT", bound=tuple[npt.NDArray[Any], ...])
"""A NamedTuple of arrays of shape (rows, ...)."""

_AT_ONCE = 1024


class Outcome(NamedTuple):
    """The results of actions, each of shape (rows,)."""

    reward: Floats
    success: Bools


class WorldBatch(ABC, Generic[TruthT, StateT]):
    """Worlds that differ in their states only; row i behaves as `world` does in the state of that row.

    Args:
        world: a world with the rules of all rows.
        rows: number of rows.
        options: further options of a family's batch.
    """

    state: StateT
    """The truths in arrays; `advance` and `draw` replace the arrays and never change them in place."""
    states: ClassVar[int | None] = None
    """Number of possible observations within an episode; None if it is not finite."""

    def __init__(self, world: World[TruthT, Any, Any], rows: int) -> None:
        self.world, self.rows = world, rows

    @abstractmethod
    def load(self, rows: Ints, truths: Sequence[TruthT]) -> None:
        """Set the states of rows."""

    def load_each(self, rows: Ints, truths: Iterable[TruthT]) -> None:
        """Set the states of rows in chunks, because a truth takes much more memory than its row."""
        truths = iter(truths)
        for first in range(0, len(rows), _AT_ONCE):
            part = rows[first : first + _AT_ONCE]
            self.load(part, list(islice(truths, len(part))))

    @abstractmethod
    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Begin another episode in these rows, as `reset` does."""

    @abstractmethod
    def truth(self, state: StateT, row: int) -> TruthT:
        """The truth of a row in this state, which may be an earlier one of its episode."""

    @abstractmethod
    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Apply a legal action in each of some rows.

        Args:
            actions: the actions, of shape (rows, ...).
            rows: the rows in which to apply them.
            draws: the random streams of all rows.
        """

    @abstractmethod
    def observe(self) -> Any:
        """The observations of all rows in new arrays, batched as Gymnasium does."""

    def taken(self, state: StateT, rows: Rows) -> StateT:
        """These rows of a state."""
        return type(state)(*(array[rows] for array in state))

    def number_states(self, most: int) -> int:
        """Begin to number observations, before the first `draw` or `load`.

        Args:
            most: greatest number of observations of a row until the next `draw`, `load` or `forget`.

        Returns:
            `states`, or if that is None a bound on the numbers until then.
        """
        if self.states is None:
            raise TypeError(f"{type(self).__name__} numbers no states")
        return self.states

    def forget(self, rows: Ints, lost: Bools) -> int:
        """Free the numbers of observations that cannot recur, and restart the bound on the others.

        Args:
            rows: the rows.
            lost: which numbers are free, of shape (len(rows), bound).

        Returns:
            The bound on the numbers until the next call.
        """
        raise TypeError(f"{type(self).__name__} forgets no numbers")

    @abstractmethod
    def place(self, rows: Rows = ALL) -> Ints:
        """The numbers of the observations in these rows, from 0; call `number_states` before."""

    @abstractmethod
    def seen(self, row: int, place: int) -> Any:
        """The observation in a row for which `place` returns this number."""


def merged(old: StateT, rows: Rows, new: StateT) -> StateT:
    """A copy of the arrays of `old` with some rows replaced by those of `new`."""
    if isinstance(rows, slice):
        return new
    both = []
    for before, after in zip(old, new, strict=True):
        array = before.copy()
        array[rows] = after
        both.append(array)
    return type(old)(*both)


def without(table: npt.NDArray[Any], rows: Ints, lost: Bools, columns: int, nothing: float = 0.0) -> npt.NDArray[Any]:
    """A table of numbered observations with the lost entries cleared and `columns` columns.

    Args:
        table: of shape (all rows, numbers, ...); it is changed.
        rows: the rows with lost entries.
        lost: which entries are lost, bool of shape (len(rows), numbers).
        columns: the bound on the numbers from now on.
        nothing: the value of a cleared entry.
    """
    for number in range(lost.shape[1]):  # one by one, as a copy of the rows takes memory
        table[rows[lost[:, number]], number] = nothing
    if columns == lost.shape[1]:
        return table
    more = np.full((len(table), columns - lost.shape[1], *table.shape[2:]), nothing, table.dtype)
    return np.concatenate([table, more], axis=1)


def chosen(table: npt.NDArray[Any], columns: Ints) -> npt.NDArray[Any]:
    """For each row of a table, the entry in the column that `columns` gives for it; shape (rows,)."""
    return table.ravel().take(np.arange(0, table.size, table.shape[1]) + columns)


def most(table: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The greatest entry of each row; column by column, since NumPy's `max` is slow for short rows."""
    greatest = table[:, 0].copy()
    for column in range(1, table.shape[1]):
        np.maximum(greatest, table[:, column], out=greatest)
    return greatest
