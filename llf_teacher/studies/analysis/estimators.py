"""Estimates over many tasks, after Agarwal et al. (2021), "Deep Reinforcement Learning at the Edge of the Statistical
Precipice": interquartile mean, performance profiles, probability of improvement.

Scores are one array of runs per task. Tasks may have different numbers of runs, and have equal weights. Intervals are
percentile intervals of the stratified bootstrap, which resamples runs within each task. If all tasks have equally many
runs, the estimates are those of the library `rliable`.
"""  # noqa: D205

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from llf_teacher.studies.analysis.resampling import bootstrap_counts
from llf_teacher.studies.analysis.statistics import LEVEL, Band, Estimate

LEAST = 10
"""Least number of runs of a task for intervals: with fewer runs their coverage is too low."""
RESAMPLES = 1999
"""Bootstrap samples; fewer for very many runs, whose intervals are narrow."""
_MOST, _LEAST = 10_000_000, 199  # greatest number of drawn runs, and least number of samples
_SEED = 0
_BATCH = 500_000  # numbers drawn at once, which bounds memory
_ROUNDING = 1e-9

Table = NDArray[np.float64]
Strata = Sequence[ArrayLike]
"""Scores: an array of shape (runs,) per task."""


class Profile(NamedTuple):
    """A performance profile."""

    thresholds: Table
    """Scores, shape (m,)."""
    band: Band
    """Share of the runs, 0 to 1, whose score is above each threshold."""


def interquartile_mean(scores: Strata) -> Estimate:
    """Mean of the middle half of all runs of all tasks, with its interval; n counts runs.

    A quarter of the runs is cut off at each end, rounded down to whole runs, as by `scipy.stats.trim_mean`.

    Raises:
        ValueError: there is no task, or a task has no runs.
    """
    tasks = _tasks(scores)
    runs = np.concatenate(tasks)
    order = np.argsort(runs, kind="stable")
    weight = np.concatenate([np.full(len(task), 1 / len(task) / len(tasks)) for task in tasks])[order]
    ranked = runs[order]

    def middle(times: Table) -> Table:
        """The interquartile mean of samples with these counts of each run, shape (samples, runs)."""
        times = times[:, order]
        mass = times * weight
        before = np.cumsum(mass, axis=1) - mass
        first = np.clip(np.floor((0.25 - before) / weight + _ROUNDING), 0, times)  # cut off whole copies
        last = np.clip(np.ceil((0.75 - before) / weight - _ROUNDING), 0, times)
        kept = (last - first) * weight
        mean: Table = (kept * ranked).sum(axis=1) / kept.sum(axis=1)
        return mean

    estimates = [middle(np.concatenate(times, axis=1)) for times in _drawn([len(task) for task in tasks])]
    return _estimate(float(middle(np.ones((1, len(runs))))[0]), estimates, tasks)


def performance_profile(scores: Strata, thresholds: ArrayLike) -> Profile:
    """Share of the runs whose score is above each threshold, averaged over the tasks, with pointwise intervals.

    Args:
        scores: an array of runs per task.
        thresholds: shape (m,).

    Raises:
        ValueError: there is no task, or a task has no runs.
    """
    levels = np.asarray(thresholds, dtype=float)
    tasks = _tasks(scores)
    mean = np.mean([_above(task, levels, np.ones((1, len(task))))[0] for task in tasks], axis=0)
    if min(map(len, tasks)) < LEAST:
        missing = np.full_like(mean, np.nan)
        return Profile(levels, Band(mean, missing, missing))
    samples = np.concatenate(
        [
            np.mean([_above(task, levels, each) for task, each in zip(tasks, times, strict=True)], axis=0)
            for times in _drawn([len(task) for task in tasks])
        ]
    )
    low, high = _ends(samples)
    return Profile(levels, Band(mean, low, high))


def probability_of_improvement(scores: Strata, others: Strata) -> Estimate:
    """Probability that a run beats a run of another algorithm, averaged over the tasks; n counts runs.

    Per task this is the statistic of Mann & Whitney (1947) divided by the number of pairs of runs; ties count half. The
    runs of both algorithms have the same seeds, and are resampled together.

    Raises:
        ValueError: there is no task, a task has no runs, or the numbers of tasks or runs differ.
    """
    first, second = _tasks(scores), _tasks(others)
    if [len(task) for task in first] != [len(task) for task in second]:
        raise ValueError(
            f"others must have as many runs per task as scores, {[len(task) for task in first]}, "
            f"got {[len(task) for task in second]}"
        )
    pairs = list(zip(first, second, strict=True))
    samples = [
        np.mean([_wins(a, b, each) for (a, b), each in zip(pairs, times, strict=True)], axis=0)
        for times in _drawn([len(task) for task in first])
    ]
    once = [_wins(a, b, np.ones((1, len(a))))[0] for a, b in pairs]
    return _estimate(float(np.mean(once)), samples, first)


def _above(runs: Table, levels: Table, times: Table) -> Table:
    """Share of the runs above each level, for samples with these counts of each run, shape (samples, levels)."""
    order = np.argsort(runs)
    share: Table = 1 - _first(times[:, order])[:, np.searchsorted(runs[order], levels, "right")] / len(runs)
    return share


def _wins(runs: Table, others: Table, times: Table) -> Table:
    """Share of the pairs whose first run is above the second, for samples with these counts, shape (samples,)."""
    order = np.argsort(others)
    below = _first(times[:, order])
    worse, not_better = (np.searchsorted(others[order], runs, side) for side in ("left", "right"))
    share: Table = (times * (below[:, worse] + below[:, not_better])).sum(axis=1) / 2 / len(runs) ** 2
    return share


def _first(times: Table) -> Table:
    """Cumulative counts of the runs, beginning with 0."""
    return np.pad(np.cumsum(times, axis=1), ((0, 0), (1, 0)))


def curve_areas(curves: ArrayLike) -> Table:
    """Area under each curve by the trapezoid rule, per turn: a curve's mean height, in its unit.

    Args:
        curves: shape (runs, turns), a value after each turn; the value before the first turn is 0.
    """
    table = np.asarray(curves, dtype=float)
    if table.ndim != 2 or not table.size:
        raise ValueError(f"curves must be a non-empty table of shape (runs, turns), got shape {table.shape}")
    areas: Table = (table.sum(axis=1) - table[:, -1] / 2) / table.shape[1]
    return areas


def bootstrap_seeds(
    table: ArrayLike, statistic: Callable[[Table], ArrayLike], resamples: int = RESAMPLES
) -> tuple[Table, Table]:
    """Ends of the percentile interval of a statistic of a table, by a bootstrap of its last axis, the seeds.

    Args:
        table: shape (..., seeds).
        statistic: gives a number or an array for such a table; NaN is ignored.
        resamples: bootstrap samples.
    """
    values = np.asarray(table, dtype=float)
    rng = np.random.default_rng(_SEED)
    seeds = values.shape[-1]
    resamples = int(np.clip(_MOST // values.size, _LEAST, resamples))
    samples = np.array([statistic(values[..., rng.integers(0, seeds, seeds)]) for _ in range(resamples)], dtype=float)
    return _ends(samples)


def _tasks(scores: Strata) -> list[Table]:
    tasks = [np.asarray(task, dtype=float) for task in scores]
    if not tasks or not all(task.ndim == 1 and task.size for task in tasks):
        raise ValueError(
            f"scores must have a non-empty array of runs for each task, got shapes {[t.shape for t in tasks]}"
        )
    return tasks


def _drawn(sizes: Sequence[int]) -> Iterator[list[Table]]:
    """Batches of bootstrap samples: per task the counts of each run, shape (samples, runs)."""
    rng = np.random.default_rng(_SEED)
    resamples = int(np.clip(_MOST // sum(sizes), _LEAST, RESAMPLES))
    batch = max(1, _BATCH // sum(sizes))
    for start in range(0, resamples, batch):
        samples = min(batch, resamples - start)
        yield [bootstrap_counts(rng, samples, size).astype(float) for size in sizes]


def _estimate(value: float, samples: Sequence[Table], tasks: Sequence[Table]) -> Estimate:
    runs = sum(map(len, tasks))
    if (few := min(map(len, tasks))) < LEAST:
        return Estimate(value, np.nan, np.nan, runs, f"{few} runs of a task")
    low, high = _ends(np.concatenate(samples))
    return Estimate(value, float(low), float(high), runs)


def _ends(samples: Table) -> tuple[Table, Table]:
    """Ends of the percentile interval along the first axis."""
    low, high = np.nanquantile(samples, ((1 - LEVEL) / 2, (1 + LEVEL) / 2), axis=0)
    return low, high
