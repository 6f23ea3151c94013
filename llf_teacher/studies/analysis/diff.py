"""Comparison of two stores: differences in common cells, and the cells of one store only."""

from array import array
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.studies.analysis.statistics import LEVEL, Estimate, mean_intervals, no_interval
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.files import reading

FIELDS = tuple(name for name in EpisodeSpec._fields if name not in ("seed", "version", "rules"))
"""The fields that identify a cell: those of an episode's spec except the seed and versions."""
Setting = tuple[str | int, ...]
"""The values of `FIELDS`."""


class Episodes(NamedTuple):
    """The episodes of a cell in one store, by seed."""

    rules: str
    seeds: NDArray[np.int64]
    """Ascending, shape (seeds,)."""
    regret: NDArray[np.float64]
    success: NDArray[np.float64]


class Contrast(NamedTuple):
    """A cell of both stores."""

    setting: Setting
    first: Episodes
    second: Episodes
    paired: bool
    """Whether the same seeds give the same worlds; then episodes are compared one by one."""
    regret: Estimate
    """Mean of the second store minus mean of the first; n counts pairs, or without pairs the seeds of the smaller cell.
    """
    success: float
    """Share of successes in the second store minus that in the first, for the compared episodes."""

    @property
    def equal(self) -> bool:
        """Whether the same seeds had the same regret and success."""
        return self.paired and all(
            np.array_equal(one, other) for one, other in zip(self.first[1:], self.second[1:], strict=True)
        )


class Comparison(NamedTuple):
    """The result of `compare`."""

    changes: Sequence[Contrast]
    """Cells of both stores, in the order of the first."""
    only: tuple[Sequence[Setting], Sequence[Setting]]
    """Cells of the first store only, and of the second only."""


def compare(first: Store, second: Store) -> Comparison:
    """Compare the episodes of two stores. If a cell has several rules, the last ones count."""
    one, other = _cells(first), _cells(second)
    both = [(setting, one[setting], other[setting]) for setting in one if setting in other]
    pairs = {
        i: found for i, (_, a, b) in enumerate(both) if a.rules == b.rules and (found := _paired(a, b)) is not None
    }
    estimates = dict(zip(pairs, mean_intervals([b.regret - a.regret for a, b in pairs.values()]), strict=True))
    changes = []
    for i, (setting, a, b) in enumerate(both):
        like = pairs.get(i, (a, b))
        success = float(like[1].success.mean() - like[0].success.mean())
        changes.append(Contrast(setting, a, b, i in pairs, estimates[i] if i in pairs else _apart(a, b), success))
    return Comparison(changes, ([s for s in one if s not in other], [s for s in other if s not in one]))


def _cells(store: Store) -> dict[Setting, Episodes]:
    names = ", ".join(FIELDS)
    query = f"SELECT {names}, rules, seed, regret, success FROM result JOIN setting USING (setting) ORDER BY rules"  # noqa: S608
    found: dict[Setting, tuple[str, array[float]]] = {}
    with reading(store.path) as db:
        for *setting, rules, seed, regret, success in db.execute(query):
            if found.get(tuple(setting), ("",))[0] != rules:
                found[tuple(setting)] = rules, array("d")
            found[tuple(setting)][1].extend((seed, regret, success))
    cells = {}
    for key, (rules, values) in found.items():
        table = np.array(values).reshape(-1, 3)
        table = table[np.argsort(table[:, 0], kind="stable")]
        cells[key] = Episodes(rules, table[:, 0].astype(np.int64), table[:, 1], table[:, 2])
    return cells


def _paired(one: Episodes, other: Episodes) -> tuple[Episodes, Episodes] | None:
    """Both cells at their common seeds; None without common seeds."""
    seeds, *rows = np.intersect1d(one.seeds, other.seeds, return_indices=True)
    if not len(seeds):
        return None
    first, second = (
        Episodes(each.rules, seeds, each.regret[row], each.success[row])
        for each, row in zip((one, other), rows, strict=True)
    )
    return first, second


def _apart(one: Episodes, other: Episodes) -> Estimate:
    """Difference of the mean regrets of unpaired cells, with the interval of Welch (1947) if each mean has one."""
    count = min(len(one.seeds), len(other.seeds))
    mean = float(other.regret.mean() - one.regret.mean())
    if why := next((reason for each in (one, other) for reason in no_interval(each.regret[:, None]) if reason), ""):
        return Estimate(mean, np.nan, np.nan, count, why)
    low, high = stats.ttest_ind(other.regret, one.regret, equal_var=False).confidence_interval(LEVEL)
    return Estimate(mean, float(low), float(high), count)
