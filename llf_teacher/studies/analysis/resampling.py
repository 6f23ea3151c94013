"""Resampling of means for many columns at once, by matrix products.

`scipy.stats.bootstrap` and `scipy.stats.permutation_test` copy the values for each resample. A mean needs only the
count, or the sign, of each value, and these serve every column of the same length. Draws and intervals equal SciPy's.
"""

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

_SEED = 0
_BATCH = 2_000_000  # numbers drawn at once, which bounds memory
_KEPT = 40_000_000  # counts, a byte each, that are cached for columns of the same length
_TIED = 1e-12  # means that differ by less than this share of the values are ties

Draw = Callable[[np.random.Generator, int, int], NDArray[np.int8]]


def bca(table: NDArray[np.float64], resamples: int, level: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ends of the BCa bootstrap intervals (Efron 1987) of the mean of each column, shape (m,).

    Args:
        table: shape (n, m), one row a unit; n is at least 2, and no column is of equal values.
        resamples: number of bootstrap samples.
        level: confidence level, 0 to 1.
    """
    mean = table.mean(axis=0)
    means = bootstrap_means(table, resamples)
    tied = _TIED * np.abs(table).max(axis=0)
    below = ((means < mean - tied).mean(axis=0) + (means <= mean + tied).mean(axis=0)) / 2
    bias = ndtri(below)
    rest = (table - mean) / np.abs(table - mean).max(axis=0)  # makes the rest independent of the unit
    acceleration = (rest**3).sum(axis=0) / (6 * (rest**2).sum(axis=0) ** 1.5)
    ends = []
    ranked = np.sort(means, axis=0)
    for z in (ndtri((1 - level) / 2), ndtri((1 + level) / 2)):
        share = ndtr(bias + (bias + z) / (1 - acceleration * (bias + z)))
        place = share * (resamples - 1)
        floor = np.clip(np.floor(place).astype(int), 0, resamples - 2)
        columns = np.arange(table.shape[1])
        ends.append(ranked[floor, columns] + (place - floor) * (ranked[floor + 1, columns] - ranked[floor, columns]))
    return ends[0], ends[1]


def bootstrap_means(table: NDArray[np.float64], resamples: int, stratum: int = 0) -> NDArray[np.float64]:
    """Means of bootstrap samples of each column, shape (resamples, m); whole rows are resampled.

    Args:
        table: shape (n, m), one row a unit.
        resamples: number of bootstrap samples.
        stratum: tables of different strata are resampled independently.
    """
    blocks = _blocks(bootstrap_counts, len(table), resamples, stratum)
    return np.concatenate([block @ table for block in blocks]) / len(table)


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
        count = sum(_beyond(block @ many, many).sum(axis=0) for block in _blocks(_signs, len(table), resamples))
        p[~few] = (count + 1) / (resamples + 1)
    return p


def _beyond(sums: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether sums are at least as far from 0 as the sum of the values."""
    return np.asarray(np.abs(sums) >= np.abs(values.sum(axis=0)) - _TIED * np.abs(values).sum(axis=0))


def bootstrap_counts(rng: np.random.Generator, rows: int, n: int) -> NDArray[np.int8]:
    """How often each of n is drawn in n draws, shape (rows, n)."""
    drawn = rng.integers(0, n, (rows, n)) + n * np.arange(rows)[:, None]
    return np.bincount(drawn.ravel(), minlength=rows * n).reshape(rows, n).astype(np.int8)


def _signs(rng: np.random.Generator, rows: int, n: int) -> NDArray[np.int8]:
    return 2 * rng.integers(0, 2, (rows, n), dtype=np.int8) - 1


def _blocks(draw: Draw, n: int, resamples: int, stratum: int = 0) -> Iterator[NDArray[np.float64]]:
    """Draws in blocks of rows, the same for the same arguments."""
    kept = not stratum and n * resamples <= _KEPT
    drawn = _kept(draw, n, resamples) if kept else _drawn(draw, n, resamples, stratum)
    return (block.astype(float) for block in drawn)


@lru_cache(maxsize=3)
def _kept(draw: Draw, n: int, resamples: int) -> tuple[NDArray[np.int8], ...]:
    return tuple(_drawn(draw, n, resamples, 0))


def _drawn(draw: Draw, n: int, resamples: int, stratum: int) -> Iterator[NDArray[np.int8]]:
    rng = np.random.default_rng([_SEED, stratum] if stratum else _SEED)
    rows = max(1, _BATCH // n)
    return (draw(rng, min(rows, resamples - start), n) for start in range(0, resamples, rows))
