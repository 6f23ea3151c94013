"""Statistics of studies: estimates with intervals, and tests. The seed is the unit of replication.

Intervals of means are BCa bootstrap intervals (Efron 1987), p-values are those of sign-flip tests (Fisher 1935), both
by `llf_teacher.studies.analysis.resampling`, whose generators have fixed seeds. Intervals of rates are Wilson's (1927),
by `scipy.stats.binomtest`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from llf_teacher.studies.analysis.resampling import bca, sign_flips

LEVEL = 0.95
"""Confidence level of every interval."""
RESAMPLES = 9999
"""Bootstrap samples; a sign-flip test is exact if there are at most as many combinations of signs."""
BAND_RESAMPLES = 999
"""Bootstrap samples for bands in plots, of which there are many."""
_RELATIVE = 1e-9  # differences below this share of the values are rounding errors


class Estimate(NamedTuple):
    """A mean with its 95 % interval, all in the unit of the values."""

    mean: float
    low: float
    """Lower end; NaN for a single value."""
    high: float
    """Upper end; NaN for a single value."""
    n: int
    """Number of values, usually seeds."""


class Band(NamedTuple):
    """Means with their 95 % intervals, pointwise; arrays of shape (m,) in the unit of the values."""

    mean: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


class Difference(NamedTuple):
    """The mean difference of paired values, and its test."""

    estimate: Estimate
    """Mean of value minus reference; n counts pairs."""
    p: float
    """Two-sided p-value under the hypothesis that the signs of the differences are random."""


class Split(NamedTuple):
    """Shares of the variance of a table of teachers and students, which sum to 1."""

    teachers: float
    """Between teachers, averaged over students."""
    students: float
    """Between students, averaged over teachers."""
    interaction: float
    """Of teachers and students: the effect of a teacher that differs between students."""
    seeds: float
    """Between the seeds of a cell."""


def variance_split(values: ArrayLike) -> Split | None:
    """Sums of squares of a balanced two-way layout, as shares of their total (Fisher 1925).

    Args:
        values: shape (teachers, students, seeds).

    Returns:
        None if all values are equal.

    Raises:
        ValueError: the table is empty or of another shape.
    """
    table = np.asarray(values, dtype=float)
    if table.ndim != 3 or not table.size:
        raise ValueError(f"values must be a non-empty table of shape (teachers, students, seeds), got {table.shape}")
    rest = table - table.mean()
    total = float((rest**2).mean())
    if total <= (_RELATIVE * np.abs(table).max()) ** 2:
        return None
    shares: list[float] = []
    for axes in ((1, 2), (0, 2), (2,)):  # each takes out what the ones before have explained
        part = rest.mean(axis=axes, keepdims=True)
        shares.append(float((part**2).mean()) / total)
        rest = rest - part
    teachers, students, interaction = shares
    return Split(teachers, students, interaction, 1 - math.fsum(shares))


def mean_band(values: ArrayLike, resamples: int = BAND_RESAMPLES) -> Band:
    """Mean of each column with its BCa bootstrap interval.

    Args:
        values: shape (n, m), one row per seed. Whole rows are resampled.
        resamples: number of bootstrap samples.

    Returns:
        The band. The interval of a column of equal values has no width; for n = 1 all intervals are NaN.

    Raises:
        ValueError: there are no values.
    """
    table = np.asarray(values, dtype=float)
    if table.ndim != 2 or not table.size:
        raise ValueError(f"values must be a non-empty table of shape (n, m), got shape {table.shape}")
    mean = table.mean(axis=0)
    if len(table) == 1:
        missing = np.full_like(mean, np.nan)
        return Band(mean, missing, missing)
    low, high = mean.copy(), mean.copy()
    varied = np.ptp(table, axis=0) > _RELATIVE * np.abs(table).max(axis=0)
    if varied.any():
        low[varied], high[varied] = bca(table[:, varied], resamples, LEVEL)
    return Band(mean, low, high)


def mean_interval(values: ArrayLike) -> Estimate:
    """Mean of values, shape (n,), with its BCa bootstrap interval; edge cases as in `mean_band`."""
    column = np.asarray(values, dtype=float).reshape(-1, 1)
    band = mean_band(column, RESAMPLES)
    return Estimate(float(band.mean[0]), float(band.low[0]), float(band.high[0]), len(column))


def rate_interval(successes: int, n: int) -> Estimate:
    """Share of successes in n independent trials, 0 to 1, with Wilson's interval.

    Raises:
        ValueError: n is below 1, or successes are not from 0 to n.
    """
    interval = stats.binomtest(successes, n).proportion_ci(LEVEL, method="wilson")
    return Estimate(successes / n, float(interval.low), float(interval.high), n)


def success_interval(successes: ArrayLike) -> Estimate:
    """Share of successes, 0 to 1, with seeds as the unit.

    Args:
        successes: booleans of shape (seeds, environments). With one environment the interval is Wilson's. The
            environments of one seed are not independent: several are averaged per seed, and the interval is that of
            the mean of these averages.
    """
    return success_intervals([successes])[0]


def success_intervals(tables: Sequence[ArrayLike]) -> list[Estimate]:
    """`success_interval` of each of several tables; tables of the same length share their draws, which is fast."""
    arrays = [np.asarray(table, dtype=float) for table in tables]
    single = [array.ndim == 2 and array.shape[1] == 1 for array in arrays]
    means = iter(mean_intervals([array.mean(axis=1) for array, one in zip(arrays, single, strict=True) if not one]))
    return [
        rate_interval(int(array.sum()), len(array)) if one else next(means)
        for array, one in zip(arrays, single, strict=True)
    ]


def mean_intervals(columns: Sequence[ArrayLike]) -> list[Estimate]:
    """`mean_interval` of each of several columns; columns of the same length share their draws, which is fast."""
    arrays = [np.asarray(column, dtype=float) for column in columns]
    found: dict[int, Estimate] = {}
    for alike in _of_a_length(arrays):
        band = mean_band(np.column_stack([arrays[i] for i in alike]), RESAMPLES)
        for i, mean, low, high in zip(alike, *band, strict=True):
            found[i] = Estimate(float(mean), float(low), float(high), len(arrays[i]))
    return [found[i] for i in range(len(arrays))]


def paired_difference(values: ArrayLike, reference: ArrayLike) -> Difference:
    """Mean of `values - reference`, both of shape (n,) and paired by seed, with its bootstrap interval.

    The test is exact for at most 13 pairs that differ (2**13 < `RESAMPLES`), and by random flips for more.
    """
    return paired_differences([np.asarray(values, dtype=float) - np.asarray(reference, dtype=float)])[0]


def paired_differences(columns: Sequence[ArrayLike]) -> list[Difference]:
    """`paired_difference` of each of several columns of differences; columns of the same length share their draws."""
    arrays = [np.asarray(column, dtype=float) for column in columns]
    p: dict[int, float] = {}
    for alike in _of_a_length(arrays):
        p |= zip(alike, sign_flips(np.column_stack([arrays[i] for i in alike]), RESAMPLES).tolist(), strict=True)
    return [Difference(estimate, p[i]) for i, estimate in enumerate(mean_intervals(arrays))]


def _of_a_length(arrays: Sequence[NDArray[np.float64]]) -> list[list[int]]:
    """Indices of the arrays, grouped by length."""
    groups: dict[int, list[int]] = {}
    for i, array in enumerate(arrays):
        groups.setdefault(len(array), []).append(i)
    return list(groups.values())


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values adjusted by Holm's method (1979), which controls the family-wise error rate; in the same order."""
    adjusted = [math.nan] * len(p_values)
    largest = 0.0
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted
