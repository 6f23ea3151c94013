"""What a report needs of a store's episodes, from its columns: sums by SQL, curves in a sorted stream.

Turns are never read. All is of one moment: a study may go on meanwhile.
"""

import itertools
import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.episodes.record import EpisodeSpec, unpack_regrets
from llf_teacher.registry import entry
from llf_teacher.studies.analysis.outcomes import SETTING, Column, Outcomes, gathered
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.database import read_only
from teachers.atoms import KINDS, Label

CHECKED = (Label.TRUTHFUL, Label.LATE, Label.PLACEBO, Label.DISTORTED)
"""Labels of claims; text without claims does not occur in studies."""
_SUMMED = (
    *("success", "regret", "turns", "words", "parse_failures", "claims", "claims_held", "advised", "followed"),
    *("unchecked", "changes"),
    *(f"said_{kind}" for kind in KINDS),
    *CHECKED,
)
_COSTS = ("input_tokens", "output_tokens", "usd", "seconds")
_SEED = EpisodeSpec._fields.index("seed")
_SHARED = ", ".join(name for name in EpisodeSpec._fields if name != "seed")

Plan = Mapping[EpisodeSpec, tuple[int, ...]]
"""What a study plays: the seeds of each setting, which is an episode with seed 0."""


class Sums(NamedTuple):
    """Of the episodes of one setting."""

    episodes: int
    first: int
    """The least seed."""
    sums: Mapping[str, float]
    """Of each column that counts something, and of the regret."""


class Answers(NamedTuple):
    """What a student got of its model, over all its episodes."""

    turns: int
    answers: int
    failures: int
    """Those that were no action."""
    truncated: int
    """Those that were cut for their length."""
    input_tokens: float | None
    """None if one is unknown; so with the next."""
    output_tokens: float | None
    usd: float | None
    seconds: float | None

    def plus(self, other: "Answers") -> "Answers":
        """Both together."""
        return Answers._make(
            None if one is None or two is None else one + two for one, two in zip(self, other, strict=True)
        )


class Curves(NamedTuple):
    """The episodes of one setting in the order of their seeds."""

    setting: EpisodeSpec
    seeds: NDArray[np.int64]
    success: NDArray[np.bool_]
    """At the last turn, shape (seeds,)."""
    regrets: NDArray[np.float64]
    """Cumulative regret after each turn, shape (seeds, max_turns); it stays as it is after the end."""


def plan(study: Study) -> Plan:
    """The settings of a study with their seeds; samples are settings of their own."""
    found: dict[EpisodeSpec, list[int]] = {}
    for _, alike in itertools.groupby(study.episodes(), lambda spec: (*spec[:_SEED], *spec[_SEED + 1 :])):
        specs = list(alike)
        found.setdefault(specs[0]._replace(seed=0), []).extend(spec.seed for spec in specs)
    return {setting: tuple(seeds) for setting, seeds in found.items()}


class Columns:
    """The episodes of a study that a store holds.

    Args:
        db: a connection of one's own.
        planned: the settings.
    """

    def __init__(self, db: sqlite3.Connection, planned: Plan) -> None:
        self._db, self._planned = db, planned
        lists = {seeds: number for number, seeds in enumerate(dict.fromkeys(planned.values()))}
        db.execute("CREATE TEMP TABLE seeds (list INTEGER, seed INTEGER, PRIMARY KEY (list, seed)) WITHOUT ROWID")
        for seeds, number in lists.items():
            db.executemany("INSERT INTO seeds VALUES (?, ?)", ((number, seed) for seed in seeds))
        db.execute("CREATE TEMP TABLE wanted (setting INTEGER PRIMARY KEY, list INTEGER, rank INTEGER)")
        settings = db.execute(f"SELECT setting, {_SHARED} FROM setting").fetchall()  # noqa: S608 (names of ours)
        self._there: dict[int, EpisodeSpec] = {}
        for number, *shared in settings:
            spec = EpisodeSpec._make((*shared[:_SEED], 0, *shared[_SEED:]))
            if spec in planned:
                self._there[number] = spec
                db.execute("INSERT INTO wanted VALUES (?, ?, 0)", (number, lists[planned[spec]]))

    def has(self, spec: EpisodeSpec) -> bool:
        """Whether an episode is there."""
        query = "SELECT 1 FROM result WHERE key = ?"
        return self._db.execute(query, (bytes.fromhex(spec.key),)).fetchone() is not None

    def count(self, seeds: Iterable[int]) -> int:
        """How many episodes of some seeds are there."""
        rows = self._db.execute(f"SELECT seed, count(*) FROM {_WANTED} GROUP BY seed")  # noqa: S608 (names of ours)
        chosen = set(seeds)
        return sum(count for seed, count in rows if seed in chosen)

    def sums(self) -> dict[EpisodeSpec, Sums]:
        """By setting; those without an episode are left out."""
        sums = ", ".join(f"total({name})" for name in _SUMMED)
        query = f"SELECT setting, count(*), min(seed), {sums} FROM {_WANTED} GROUP BY setting"  # noqa: S608
        found: dict[EpisodeSpec, Sums] = {}
        for setting, count, first, *values in self._db.execute(query):
            found[self._there[setting]] = Sums(count, first, dict(zip(_SUMMED, values, strict=True)))
        return found

    def answers(self) -> dict[str, Answers]:
        """Of each student that asks a model."""
        sums = ", ".join(f"total({name})" for name in ("turns", "parse_failures", "truncated", "answers"))
        known = ", ".join(f"count({name}) < count(*), total({name})" for name in _COSTS)
        query = f"SELECT setting, {sums}, {known} FROM {_WANTED} WHERE answers IS NOT NULL GROUP BY setting"  # noqa: S608
        found: dict[str, Answers] = {}
        for setting, turns, failures, truncated, answers, *costs in self._db.execute(query):
            told = Answers(
                int(turns),
                int(answers),
                int(failures),
                int(truncated),
                *(None if unknown else total for unknown, total in zip(costs[::2], costs[1::2], strict=True)),
            )
            student = self._there[setting].student
            found[student] = told if student not in found else found[student].plus(told)
        return found

    def sampled(self) -> Iterator[dict[str, Any]]:
        """The episodes of a study of several samples, as `llf_teacher.studies.analysis.pass_at_k` takes them."""
        rows = self._db.execute(f"SELECT setting, seed, first_success FROM {_WANTED}")  # noqa: S608 (names of ours)
        for setting, seed, first in rows:
            yield self._there[setting]._asdict() | {"seed": seed, "first_success": first}

    def failures(self) -> dict[tuple[str, str], int]:
        """How many of the study's episodes have failed, and were not played since, by student and reason."""
        wanted = {setting: set(seeds) for setting, seeds in self._planned.items()}
        found: Counter[tuple[str, str]] = Counter()
        for seed, reason, *shared in self._db.execute(f"SELECT seed, reason, {_SHARED} FROM failure"):  # noqa: S608
            setting = EpisodeSpec._make((*shared[:_SEED], 0, *shared[_SEED:]))
            if seed in wanted.get(setting, ()):
                found[setting.student, reason] += 1
        return dict(sorted(found.items()))

    def curves(self, order: Iterable[EpisodeSpec]) -> Iterator[Curves]:
        """The settings that have episodes, one by one in the given order; one that is not in it is left out."""
        ranks = {spec: rank for rank, spec in enumerate(order)}
        for setting, spec in self._there.items():
            self._db.execute("UPDATE wanted SET rank = ? WHERE setting = ?", (ranks.get(spec, -1), setting))
        specs = list(ranks)
        rows = self._db.execute(
            f"SELECT rank, seed, success, regrets FROM {_WANTED} WHERE rank >= 0 ORDER BY rank, seed"  # noqa: S608
        )
        for rank, alike in itertools.groupby(rows, lambda row: row[0]):
            yield _curves(specs[rank], list(alike))

    def outcomes(self, study: Study) -> Outcomes:
        """What came of the episodes, by teacher and student; environments with the same grid are averaged."""
        names = "setting, seed, regret, success, coalesce(first_success, 9e999)"
        rows = self._db.execute(f"SELECT {names} FROM {_WANTED} ORDER BY setting")  # noqa: S608 (names of ours)
        tables = {
            self._there[number]: np.array(list(alike)) for number, alike in itertools.groupby(rows, lambda row: row[0])
        }
        ordered = [(spec, tables[spec]) for spec in self._planned if spec in tables]
        return gathered((_column(spec, table) for spec, table in ordered), study.grid)


def _column(spec: EpisodeSpec, table: NDArray[np.float64]) -> Column:
    told = spec._asdict() | {"family": entry(spec.id).family.name}
    seeds = table[:, 1].astype(np.int64)
    return Column(tuple(told[name] for name in SETTING), seeds, table[:, 2:], np.full_like(seeds, spec.sample))


_WANTED = "result CROSS JOIN wanted USING (setting) CROSS JOIN seeds USING (list, seed)"  # in this order: rows once


def _curves(spec: EpisodeSpec, rows: list[tuple[int, int, int, bytes]]) -> Curves:
    regrets = np.zeros((len(rows), spec.max_turns))
    for place, row in zip(regrets, rows, strict=True):
        turns = unpack_regrets(row[3])
        place[: len(turns)] = turns
    np.cumsum(regrets, axis=1, out=regrets)
    return Curves(spec, np.array([row[1] for row in rows]), np.array([row[2] for row in rows], dtype=np.bool_), regrets)


@contextmanager
def columns(store: Store, planned: Plan) -> Iterator[Columns]:
    """Read a store's columns through a connection of their own, in one transaction."""
    with read_only(store.path) as db:
        db.execute("BEGIN")
        yield Columns(db, planned)
