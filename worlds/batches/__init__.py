"""Batches: many worlds of one class and options in arrays, a row each. A family's is in the module of its name."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from worlds.batches.streams import ALL, Bools, Floats, Ints, Rows, Streams
from worlds.world import TruthT, World

__all__ = ["ALL", "Bools", "Floats", "Ints", "Outcome", "Rows", "StateT", "WorldBatch", "chosen", "merged", "most"]

StateT = TypeVar("StateT", bound=tuple[npt.NDArray[Any], ...])
"""A NamedTuple of arrays, a row each."""


class Outcome(NamedTuple):
    """What actions come to, a row each."""

    reward: Floats
    success: Bools


class WorldBatch(ABC, Generic[TruthT, StateT]):
    """Worlds that are alike in all but their states; row i is one, and does what `world` would in that state.

    Args:
        world: one of the worlds, for its rules.
        rows: how many there are.
        options: what a family's batch may be told besides.
    """

    state: StateT
    """The truths in arrays, which are never changed in place: `advance` and `draw` put others in their place."""
    states: ClassVar[int | None] = None
    """How many observations there can be within an episode, numbered from 0; None if they are not finitely many."""

    def __init__(self, world: World[TruthT, Any, Any], rows: int) -> None:
        self.world, self.rows = world, rows

    @abstractmethod
    def load(self, rows: Ints, truths: Sequence[TruthT]) -> None:
        """Put rows into given states."""

    @abstractmethod
    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Begin another episode in these rows, as a `reset` would."""

    @abstractmethod
    def truth(self, state: StateT, row: int) -> TruthT:
        """The truth of a row, in this state or an earlier one of its episode."""

    @abstractmethod
    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Apply legal actions in some of the rows, one each.

        Args:
            actions: an action for each of these rows.
            rows: which they are.
            draws: the streams of all rows' worlds.
        """

    @abstractmethod
    def observe(self) -> Any:
        """What is observed in each row; new arrays, as Gymnasium batches observations."""

    def taken(self, state: StateT, rows: Rows) -> StateT:
        """These rows of a state."""
        return type(state)(*(array[rows] for array in state))

    def place(self, rows: Rows = ALL) -> Ints:
        """The number of what is observed in these rows, below `states`."""
        raise TypeError(f"{type(self).__name__} numbers no states")

    def seen(self, row: int, place: int) -> Any:
        """What is observed in a row where `place` gives this number."""
        raise TypeError(f"{type(self).__name__} numbers no states")


def merged(old: StateT, rows: Rows, new: StateT) -> StateT:
    """The arrays of `old`, with those of `new` in the place of some rows; neither is changed."""
    if isinstance(rows, slice):
        return new
    both = []
    for before, after in zip(old, new, strict=True):
        array = before.copy()
        array[rows] = after
        both.append(array)
    return type(old)(*both)


def chosen(table: npt.NDArray[Any], columns: Ints) -> npt.NDArray[Any]:
    """The entry of each row of a table in a column of its own."""
    return table.ravel().take(np.arange(0, table.size, table.shape[1]) + columns)


def most(table: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The greatest entry of each row; column by column, since NumPy's `max` takes its time with short rows."""
    greatest = table[:, 0].copy()
    for column in range(1, table.shape[1]):
        np.maximum(greatest, table[:, column], out=greatest)
    return greatest
