"""Outcomes of the episodes of a store, as arrays: for each teacher with each student one value per seed.

Memory grows by some 40 bytes per episode. Environments of a family with the same teachers and students are averaged
within a seed, the unit of replication. Episodes are compared only if everything else that determines them is equal,
also versions and rules.
"""

from array import array
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]


class Group(NamedTuple):
    """The common setting of compared teachers and students."""

    family: str
    instruction_type: str
    feedback_type: str
    max_turns: int
    version: str
    rules: str
    lessons: int
    taught: str
    worlds: str
    options: str
    ids: tuple[str, ...]
    """The environments that are averaged."""


class Endings(NamedTuple):
    """One teacher with one student, at the seeds at which all environments of the group were played."""

    seeds: NDArray[np.int64]
    """Ascending, shape (seeds,)."""
    regret: Numbers
    """Mean over the environments, shape (seeds,)."""
    success: Numbers
    """Share of the environments with success at the last turn, shape (seeds,)."""
    first: Numbers
    """The turn of the first success, infinite if there is none; shape (seeds, environments)."""


Pair = tuple[str, str]
"""A teacher and a student."""
Outcomes = dict[Group, dict[Pair, Endings]]
SETTING = (*Group._fields[:-1], "id", "teacher", "student")
"""The common fields of a column's episodes."""


class Column(NamedTuple):
    """The episodes of one setting, in any order."""

    setting: tuple[Any, ...]
    """The fields of `SETTING`."""
    seeds: NDArray[np.int64]
    values: Numbers
    """Regret, success, and the turn of the first success, infinite if there is none; shape (seeds, 3)."""
    samples: NDArray[np.int64]
    """The sample number of each episode; regret and success are averages over samples, `first` belongs to the first
    sample.
    """


def outcomes(rows: Iterable[Any], alike: Callable[[str], Any] | None = None) -> Outcomes:
    """The outcomes of episodes.

    Args:
        rows: episodes in any order, each with the fields of `EpisodeSpec` and `EpisodeRow` by name.
        alike: see `gathered`.
    """
    columns: dict[tuple[Any, ...], tuple[array[int], array[float], array[int]]] = {}
    for row in rows:
        setting = tuple([row[name] for name in SETTING])
        if (column := columns.get(setting)) is None:
            column = columns[setting] = array("q"), array("d"), array("q")
        first = np.inf if row["first_success"] is None else row["first_success"]
        column[0].append(row["seed"])
        column[1].extend((row["regret"], row["success"], first))
        column[2].append(row["sample"])
    return gathered(
        (
            Column(setting, np.array(seeds, np.int64), np.array(values).reshape(-1, 3), np.array(which, np.int64))
            for setting, (seeds, values, which) in columns.items()
        ),
        alike,
    )


def gathered(columns: Iterable[Column], alike: Callable[[str], Any] | None = None) -> Outcomes:
    """The outcomes of columns; groups and pairs keep the order of their first columns.

    Args:
        columns: one or, with samples, several per setting.
        alike: gives a key per id; environments of a family with equal keys are averaged. By default the key is the
            teachers and students.
    """
    samples: dict[tuple[Any, ...], list[Column]] = {}
    for column in columns:
        samples.setdefault(column.setting, []).append(column)
    by_setting = {setting: _sorted(each) for setting, each in samples.items()}
    found: Outcomes = {}
    for group, pairs in _groups(by_setting, alike):
        tables = {pair: [by_setting[*group[:-1], id, *pair] for id in group.ids] for pair in pairs}
        found[group] = {pair: cell for pair, each in tables.items() if len((cell := _cell(each)).seeds)}
    return found


def _groups(
    settings: Iterable[tuple[Any, ...]], alike: Callable[[str], Any] | None
) -> Iterator[tuple[Group, list[Pair]]]:
    """The groups, each with the pairs of all of its environments."""
    pairs: dict[tuple[Any, ...], dict[str, dict[Pair, None]]] = {}
    for *common, id, teacher, student in settings:
        pairs.setdefault(tuple(common), {}).setdefault(id, {})[teacher, student] = None
    for shared, by_id in pairs.items():
        together: dict[Any, list[str]] = {}
        for id, each in by_id.items():
            together.setdefault(alike(id) if alike else frozenset(each), []).append(id)
        for ids in together.values():
            mine = [pair for pair in by_id[ids[0]] if all(pair in by_id[id] for id in ids)]
            yield Group._make((*shared, tuple(ids))), mine


def _sorted(columns: list[Column]) -> tuple[NDArray[np.int64], Numbers]:
    """The different seeds, and three values for each."""
    known = np.concatenate([np.column_stack([column.seeds, column.samples]) for column in columns])
    known, kept = np.unique(known, axis=0, return_index=True)  # a seed's first sample comes first
    values = np.concatenate([column.values for column in columns])[kept]
    seeds, first, place, counts = np.unique(known[:, 0], return_index=True, return_inverse=True, return_counts=True)
    means = [np.bincount(place, weights=each) / counts for each in values[:, :2].T]
    return seeds, np.column_stack([*means, values[first, 2]])


def _cell(tables: list[tuple[NDArray[np.int64], Numbers]]) -> Endings:
    seeds = tables[0][0]
    for other, _ in tables[1:]:
        seeds = np.intersect1d(seeds, other, assume_unique=True)
    values = np.array([table[np.searchsorted(own, seeds)] for own, table in tables])  # (environments, seeds, 3)
    return Endings(seeds, values[..., 0].mean(axis=0), values[..., 1].mean(axis=0), values[..., 2].T)


def common_seeds(*cells: Endings) -> NDArray[np.int64]:
    """The seeds of all cells."""
    seeds = cells[0].seeds
    for cell in cells[1:]:
        seeds = np.intersect1d(seeds, cell.seeds, assume_unique=True)
    return seeds


def at_seeds(cell: Endings, seeds: NDArray[np.int64]) -> Endings:
    """A cell with only some of its seeds."""
    chosen = np.searchsorted(cell.seeds, seeds)
    return Endings(cell.seeds[chosen], cell.regret[chosen], cell.success[chosen], cell.first[chosen])


def paired(*cells: Endings) -> list[Endings]:
    """The cells with only their common seeds."""
    seeds = common_seeds(*cells)
    return [at_seeds(cell, seeds) for cell in cells]
