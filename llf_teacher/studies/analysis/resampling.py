"""Sign-flip tests of many columns at once, by matrix products, and counts for the bootstrap.

`scipy.stats.permutation_test` copies the values for each resample. A mean needs only the sign of each value, and signs
serve every column of the same length. p-values equal SciPy's.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

_SEED = 0
_BATCH = 2_000_000  # numbers drawn at once, which bounds memory
_KEPT = 40_000_000  # counts, a byte each, that are cached for columns of the same length
_TIED = 1e-12  # means that differ by less than this share of the values are ties


def sign_flips(table: NDArray[np.float64], resamples: int) -> NDArray[np.float64]:
    """Two-sided p-value of each column under the hypothesis that its signs are random (Fisher 1935), shape (m,).

    The test is exact, over all combinations of signs, if there are at most `resamples`; values of 0 have no sign.

    Args:
        table: shape (n, m), one row a pair.
        resamples: number of random combinations otherwise.
    """
    p = np.ones(table.shape[1])
    signed = table != 0
    few = signed.sum(axis=0) <= np.log2(resamples)
    for column in np.flatnonzero(few & signed.any(axis=0)):
        values = table[signed[:, column], column]
        ways = 2 * (np.arange(2 ** len(values))[:, None] >> np.arange(len(values)) & 1) - 1
        p[column] = _beyond(ways @ values, values).mean()
    if not few.all():
        many = table[:, ~few]
        count = sum(_beyond(block @ many, many).sum(axis=0) for block in _blocks(len(table), resamples))
        p[~few] = (count + 1) / (resamples + 1)
    return p


def _beyond(sums: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether sums are at least as far from 0 as the sum of the values."""
    return np.asarray(np.abs(sums) >= np.abs(values.sum(axis=0)) - _TIED * np.abs(values).sum(axis=0))


def bootstrap_counts(rng: np.random.Generator, rows: int, n: int) -> NDArray[np.int8]:
    """How often n draws draw each of n values, shape (rows, n)."""
    drawn = rng.integers(0, n, (rows, n)) + n * np.arange(rows)[:, None]
    return np.bincount(drawn.ravel(), minlength=rows * n).reshape(rows, n).astype(np.int8)


def _signs(rng: np.random.Generator, rows: int, n: int) -> NDArray[np.int8]:
    return 2 * rng.integers(0, 2, (rows, n), dtype=np.int8) - 1


def _blocks(n: int, resamples: int) -> Iterator[NDArray[np.float64]]:
    """Random signs in blocks of rows, the same for the same arguments."""
    drawn = _kept(n, resamples) if n * resamples <= _KEPT else _drawn(n, resamples)
    return (block.astype(float) for block in drawn)


@lru_cache(maxsize=3)
def _kept(n: int, resamples: int) -> tuple[NDArray[np.int8], ...]:
    return tuple(_drawn(n, resamples))


def _drawn(n: int, resamples: int) -> Iterator[NDArray[np.int8]]:
    rng = np.random.default_rng(_SEED)
    rows = max(1, _BATCH // n)
    return (_signs(rng, min(rows, resamples - start), n) for start in range(0, resamples, rows))
