"""Independent streams of random numbers for the rows of a batch."""

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from typing_extensions import override

Ints: TypeAlias = npt.NDArray[np.integer[Any]]
Floats: TypeAlias = npt.NDArray[np.float64]
Bools: TypeAlias = npt.NDArray[np.bool_]
Rows: TypeAlias = slice | Ints
"""All rows, or those of these indices."""
ALL = slice(None)


class Streams:
    """A SplitMix64 generator (Steele, Lea & Flood 2014) per row; a row's draws do not depend on those of others.

    Args:
        states: initial states, uint64 of shape (rows,).
    """

    def __init__(self, states: npt.NDArray[np.uint64]) -> None:
        self.states = states

    def random(self, rows: Rows = ALL) -> Floats:
        """A number from 0 to 1 (exclusive) for each of these rows."""
        states = self.states[rows] + _GAMMA
        self.states[rows] = states
        numbers: Floats = (_mixed(states) >> _SPARE).astype(np.float64)
        return numbers * _UNIT

    def permutations(self, count: int, rows: Rows = ALL) -> Ints:
        """The integers from 0 to `count` (exclusive) in random order for each of these rows, shape (rows, count)."""
        every = np.arange(len(self.states[rows]))
        order = np.tile(np.arange(count), (len(every), 1))
        for last in range(count - 1, 0, -1):  # Fisher and Yates
            place = self.integers(last + 1, rows)
            order[every, place], order[:, last] = order[:, last].copy(), order[every, place]
        return order

    def beside(self, number: int, rows: Rows = ALL) -> npt.NDArray[np.uint64]:
        """States of further streams, derived from the present states and a number, shape (rows,)."""
        return _mixed(self.states[rows] ^ np.uint64(1 + number))

    def integers(self, counts: Any, rows: Rows = ALL) -> Ints:
        """An integer from 0 to `counts` (exclusive) for each of these rows."""
        numbers: Ints = (self.random(rows) * counts).astype(np.int64)
        return numbers

    def standard_normal(self, rows: Rows = ALL) -> Floats:
        """A standard normal number for each of these rows, by the method of Box and Muller."""
        radius = np.sqrt(-2.0 * np.log1p(-self.random(rows)))
        return radius * np.cos(math.tau * self.random(rows))

    def stream(self, row: int) -> "Stream":
        """A copy of a row's stream as a generator."""
        return Stream(self.states[row : row + 1].copy())


def _mixed(states: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """The numbers that SplitMix64 makes of states."""
    mixed = states.copy()
    for shift, factor in _ROUNDS:
        mixed ^= mixed >> shift
        mixed *= factor
    mixed ^= mixed >> _LAST
    return mixed


_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_ROUNDS = (
    (np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)),
    (np.uint64(27), np.uint64(0x94D049BB133111EB)),
)
_LAST, _SPARE, _UNIT = np.uint64(31), np.uint64(11), 2.0**-53


class Stream(np.random.Generator):
    """A row of `Streams` as a generator: single draws equal those of the row in a batch.

    Draws of arrays, as in resets, come from a separate stream.

    Args:
        state: state of the row's stream, uint64 of shape (1,).
        beside: the separate stream; None: a stream seeded by the state.
    """

    def __init__(self, state: npt.NDArray[np.uint64], beside: np.random.BitGenerator | None = None) -> None:
        super().__init__(beside or np.random.PCG64(int(state[0])))
        self._own = Streams(state)

    @override
    def random(self, size: Any = None, *args: Any, **kwargs: Any) -> Any:
        return super().random(size, *args, **kwargs) if size is not None else float(self._own.random()[0])

    @override
    def integers(self, low: Any, high: Any = None, size: Any = None, *args: Any, **kwargs: Any) -> Any:
        if size is not None or args or kwargs:
            return super().integers(low, high, size, *args, **kwargs)
        low, high = (0, low) if high is None else (low, high)
        return int(low + self._own.integers(high - low)[0])

    def uniform(self, low: Any = 0.0, high: Any = 1.0, size: Any = None) -> Any:
        """As NumPy's `uniform`; without `size`, one draw for each pair of bounds."""
        if size is not None:
            return super().uniform(low, high, size)
        low, high = np.broadcast_arrays(np.asarray(low, float), high)
        draws = np.reshape([self._own.random()[0] for _ in range(low.size)], low.shape)
        return low + (high - low) * draws

    @override
    def standard_normal(self, size: Any = None, *args: Any, **kwargs: Any) -> Any:
        return super().standard_normal(size, *args, **kwargs) if size is not None else self._own.standard_normal()[0]

    def permutation(self, x: Any, axis: int = 0) -> Any:
        """As NumPy's `permutation`; for an integer, equal to a row's draw in a batch."""
        return super().permutation(x, axis) if not isinstance(x, int) else self._own.permutations(x)[0]

    def streams_beside(self, count: int) -> list["Stream"]:
        """Other streams, as `Streams.beside` gives them."""
        return [Stream(self._own.beside(number)) for number in range(count)]

    def __reduce__(self) -> tuple[Any, ...]:
        return Stream, (self._own.states.copy(), self.bit_generator)
