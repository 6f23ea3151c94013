"""Statistics of studies: estimates with intervals, and tests. The seed is the unit of replication.

Intervals of means are Student's t (1908), and are omitted for data where their coverage is too low: `no_interval` has
the rule, docs/internals/calibration.md the measured coverage. Intervals of rates are exact
(Clopper & Pearson 1934), by `scipy.stats.binomtest`. p-values are those of sign-flip tests (Fisher 1935), by
`llf_teacher.studies.analysis.resampling`, whose generators have fixed seeds.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from llf_teacher.studies.analysis.resampling import sign_flips

LEVEL = 0.95
"""Confidence level of every interval."""
RESAMPLES = 9999
"""Random combinations of signs; a sign-flip test is exact if there are at most as many combinations."""
LEAST, MANY = 5, 80
"""Least number of values for an interval of the mean, and for an interval of skewed values."""
TINY = 0.001
"""The least p-value that texts show."""
_NONZERO = 15  # enough values other than 0, even if more are 0
_SKEW, _SPREAD = 10, 100  # n is at least so many times the squared skew, and the squared ratio of spread and mean
_RELATIVE = 1e-9  # differences below this share of the values are rounding errors

Numbers = NDArray[np.float64]


class Estimate(NamedTuple):
    """A mean with its 95 % interval, all in the unit of the values."""

    mean: float
    low: float
    """Lower end; NaN without an interval."""
    high: float
    """Upper end; NaN without an interval."""
    n: int
    """Number of values, usually seeds."""
    why: str = ""
    """Why there is no interval."""
    values: tuple[float, ...] = ()
    """Without an interval, the values in ascending order."""

    def text(self, digits: int = 2) -> str:
        """The mean with its interval, or with the reason why there is none."""
        if self.low != self.low:  # NaN
            return f"{self.mean:.{digits}f} (no interval: {self.why})"
        return f"{self.mean:.{digits}f} [{self.low:.{digits}f}, {self.high:.{digits}f}]"


class Band(NamedTuple):
    """Means with their 95 % intervals, pointwise; arrays of shape (m,) in the unit of the values.

    Ends are NaN without an interval.
    """

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
    """Interaction: the effect of a teacher that differs between students."""
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
    for axes in ((1, 2), (0, 2), (2,)):  # each removes what the previous ones have explained
        part = rest.mean(axis=axes, keepdims=True)
        shares.append(float((part**2).mean()) / total)
        rest = rest - part
    teachers, students, interaction = shares
    return Split(teachers, students, interaction, 1 - math.fsum(shares))


def no_interval(table: Numbers) -> list[str]:
    """For each column the reason why its mean has no interval; empty if Student's t has good coverage for such data.

    A mean has an interval if there are at least `LEAST` values, not all equal, and either at least `MANY` of them, 15
    not 0, or

    - at least half of the values, or 15, are not 0,
    - n >= 10 g², where g is the sample's skewness, and
    - values of one sign have a standard deviation of at most sqrt(n) / 10 of their mean: such data are skewed, by at
      least two of these ratios if they are gamma distributed, and n > 25 g² is the rule of Cochran (1977). The ratio
      tells it better than the skewness of few values.

    Args:
        table: shape (n, m), one row a unit.
    """
    n = len(table)
    if n < LEAST:
        return [_few(n)] * table.shape[1]
    size = np.abs(table).max(axis=0)
    equal = np.ptp(table, axis=0) <= _RELATIVE * size
    mean, spread = table.mean(axis=0), table.std(axis=0, ddof=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        skew = stats.skew(np.where(equal, 0.0, table / np.where(size > 0, size, 1.0)), axis=0)
    signed = (table != 0).sum(axis=0)
    skewed = (_SKEW * skew**2 > n) | (
        ((table >= 0).all(axis=0) | (table <= 0).all(axis=0)) & (_SPREAD * spread**2 > n * mean**2)
    )
    zeros = signed < min(_NONZERO, n / 2 if n < MANY else n)
    why = np.select([equal, zeros, skewed & (n < MANY)], ["all equal", "zeros", "skewed"], "")
    return [f"{n - c} of {n} are 0" if each == "zeros" else str(each) for each, c in zip(why, signed, strict=True)]


def mean_band(values: ArrayLike) -> Band:
    """Mean of each column with its interval, if there is one.

    Args:
        values: shape (n, m), one row per seed.

    Raises:
        ValueError: there are no values.
    """
    return _band(values)[0]


def _band(values: ArrayLike) -> tuple[Band, list[str]]:
    """The band, and the reasons of columns without an interval."""
    table = np.asarray(values, dtype=float)
    if table.ndim != 2 or not table.size:
        raise ValueError(f"values must be a non-empty table of shape (n, m), got shape {table.shape}")
    mean, why = table.mean(axis=0), no_interval(table)
    low, high = np.full_like(mean, np.nan), np.full_like(mean, np.nan)
    there = np.array([not each for each in why])
    if there.any():
        low[there], high[there] = stats.t.interval(
            LEVEL, len(table) - 1, mean[there], stats.sem(table[:, there], axis=0)
        )
    return Band(mean, low, high), why


def mean_interval(values: ArrayLike) -> Estimate:
    """Mean of values, shape (n,), with its interval, or with the reason why there is none."""
    return mean_intervals([values])[0]


def ratio_interval(parts: ArrayLike, wholes: ArrayLike) -> Estimate | None:
    """The ratio of two sums over units, shape (n,), with its interval; None if the second sum is 0.

    The interval is that of the mean of its linearized values (Cochran 1977, section 2.11). Without an interval,
    `values` are the ratios of the units with a ratio.
    """
    part, whole = np.asarray(parts, dtype=float), np.asarray(wholes, dtype=float)
    if not (total := whole.sum()):
        return None
    ratio = part.sum() / total
    found = mean_interval(ratio + (part - ratio * whole) / whole.mean())
    own = (part[whole != 0] / whole[whole != 0]).tolist()
    return found._replace(mean=float(ratio), values=tuple(sorted(own)) if found.why else ())


def rate_interval(successes: int, n: int) -> Estimate:
    """Share of successes in n independent trials, 0 to 1, with its exact interval; no interval below `LEAST` trials.

    Raises:
        ValueError: n is below 1, or successes are not from 0 to n.
    """
    low, high = _exact(successes, n, LEVEL)
    if n < LEAST:
        values = (0.0,) * (n - successes) + (1.0,) * successes
        return Estimate(successes / n, math.nan, math.nan, n, _few(n), values)
    return Estimate(successes / n, low, high, n)


@cache
def _exact(successes: int, n: int, level: float) -> tuple[float, float]:
    """Ends of the interval of Clopper and Pearson."""
    interval = stats.binomtest(successes, n).proportion_ci(level, method="exact")
    return float(interval.low), float(interval.high)


def _few(n: int) -> str:
    return "one seed" if n == 1 else f"{n} seeds"


def share_interval(shares: ArrayLike) -> Estimate:
    """Mean of shares of successes, shape (n,), with an exact interval if they are single trials, 0 or 1."""
    values = np.asarray(shares, dtype=float)
    return rate_interval(int(values.sum()), len(values)) if np.isin(values, (0, 1)).all() else mean_interval(values)


def rate_band(shares: ArrayLike) -> Band:
    """Mean of each column of shares of successes, shape (n, m); of single trials, 0 or 1, with exact intervals."""
    table = np.asarray(shares, dtype=float)
    if not np.isin(table, (0, 1)).all():
        return mean_band(table)
    found = np.array([rate_interval(int(column.sum()), len(column))[:3] for column in table.T])
    return Band(*found.T)


def rate_differences(shares: ArrayLike, others: ArrayLike) -> Band:
    """Mean difference of paired shares of successes, both of shape (n, m), by column.

    For single trials the interval is exact, and conservative: it combines two exact 97.5 % intervals, for the shares of
    pairs where only the first or only the second succeeds.
    """
    one, other = np.asarray(shares, dtype=float), np.asarray(others, dtype=float)
    difference = one - other
    if len(one) < LEAST or not (np.isin(one, (0, 1)).all() and np.isin(other, (0, 1)).all()):
        return mean_band(difference)
    n, level = len(difference), (1 + LEVEL) / 2
    ends = []
    for column in difference.T:
        (low_gained, high_gained), (low_lost, high_lost) = (
            _exact(int((column == sign).sum()), n, level) for sign in (1, -1)
        )
        ends.append((low_gained - high_lost, high_gained - low_lost))
    low, high = np.array(ends).T
    return Band(difference.mean(axis=0), low, high)


def success_interval(successes: ArrayLike) -> Estimate:
    """Share of successes, 0 to 1, with seeds as the unit.

    Args:
        successes: booleans of shape (seeds, environments). With one environment the interval is exact. The
            environments of one seed are not independent: several are averaged per seed, and the interval is that of
            the mean of these averages.
    """
    return success_intervals([successes])[0]


def success_intervals(tables: Sequence[ArrayLike]) -> list[Estimate]:
    """`success_interval` of each of several tables."""
    arrays = [np.asarray(table, dtype=float) for table in tables]
    single = [array.ndim == 2 and array.shape[1] == 1 for array in arrays]
    means = iter(mean_intervals([array.mean(axis=1) for array, one in zip(arrays, single, strict=True) if not one]))
    return [
        rate_interval(int(array.sum()), len(array)) if one else next(means)
        for array, one in zip(arrays, single, strict=True)
    ]


def mean_intervals(columns: Sequence[ArrayLike]) -> list[Estimate]:
    """`mean_interval` of each of several columns."""
    arrays = [np.asarray(column, dtype=float) for column in columns]
    found: dict[int, Estimate] = {}
    for alike in _of_a_length(arrays):
        band, why = _band(np.column_stack([arrays[i] for i in alike]))
        for i, reason, mean, low, high in zip(alike, why, *band, strict=True):
            values = tuple(sorted(arrays[i].tolist())) if reason else ()
            found[i] = Estimate(float(mean), float(low), float(high), len(arrays[i]), reason, values)
    return [found[i] for i in range(len(arrays))]


def paired_difference(values: ArrayLike, reference: ArrayLike) -> Difference:
    """Mean of `values - reference`, both of shape (n,) and paired by seed, with its interval.

    The test is exact for at most 13 pairs that differ (2**13 < `RESAMPLES`), and uses random flips for more.
    """
    return paired_differences([np.asarray(values, dtype=float) - np.asarray(reference, dtype=float)])[0]


def paired_differences(columns: Sequence[ArrayLike]) -> list[Difference]:
    """`paired_difference` of each of several columns of differences; columns of the same length share their draws."""
    arrays = [np.asarray(column, dtype=float) for column in columns]
    p: dict[int, float] = {}
    for alike in _of_a_length(arrays):
        p |= zip(alike, sign_flips(np.column_stack([arrays[i] for i in alike]), RESAMPLES).tolist(), strict=True)
    return [Difference(estimate, p[i]) for i, estimate in enumerate(mean_intervals(arrays))]


def exact_p(differences: ArrayLike) -> float:
    """The p-value of `paired_difference`."""
    return float(sign_flips(np.asarray(differences, dtype=float).reshape(-1, 1), RESAMPLES)[0])


def _of_a_length(arrays: Sequence[NDArray[np.float64]]) -> list[list[int]]:
    """Indices of the arrays, grouped by length."""
    groups: dict[int, list[int]] = {}
    for i, array in enumerate(arrays):
        groups.setdefault(len(array), []).append(i)
    return list(groups.values())


def p_words(p: float | None) -> str:
    """A p-value as text; empty without one."""
    return "" if p is None else f"< {TINY}" if p < TINY else f"{p:.3f}"


def holm(p_values: Sequence[float]) -> list[float]:
    """p-values adjusted by Holm's method (1979), which controls the family-wise error rate; in the same order."""
    adjusted = [math.nan] * len(p_values)
    largest = 0.0
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda i: p_values[i])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted
