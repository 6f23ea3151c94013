"""The data of a report from the columns of a store: sums by SQL, curves in a sorted stream.

Turns are not read. All queries see the same state of the store, though a study may go on.
"""

import itertools
import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.episodes.record import READINGS, EpisodeSpec, unpack_regrets
from llf_teacher.registry import entry
from llf_teacher.studies.analysis.outcomes import SETTING, Column, Outcomes, gathered
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.store import Store
from llf_teacher.studies.store.files import reading
from teachers.atoms import KINDS, Label

_FLAT = (Label.TRUTHFUL, Label.LATE, Label.PLACEBO, Label.DISTORTED)
CHECKED = (*_FLAT, Label.HEDGED)
"""Labels of checked claims."""
_SUMMED = (
    *("success", "regret", "turns", "words", "parse_failures", "claims", "claims_held", "advised", "followed"),
    *("unchecked", "changes", *READINGS, "unbuilt", "withheld"),
    *("teacher_answers", "teacher_cut", "teacher_empty", "teacher_repeats", "teacher_seconds"),
    *(f"said_{kind}" for kind in KINDS),
    *CHECKED,
)
_HEDGED = " - ".join(("claims", *_FLAT))
_COSTS = ("input_tokens", "output_tokens", "usd", "seconds")
INFORMATION = (
    *("turns", "measured", "unmeasured", "bits", "at_least", "measured_words", "valued_bits", "saved"),
    *(f"bits_{kind}" for kind in KINDS),
)
"""Columns about the amount of teaching."""
_SEED = EpisodeSpec._fields.index("seed")
_SHARED = ", ".join(name for name in EpisodeSpec._fields if name != "seed")

Plan = Mapping[EpisodeSpec, tuple[int, ...]]
"""The seeds of each setting of a study; a setting is an episode's spec with seed 0."""


class Sums(NamedTuple):
    """Sums over the episodes of one setting."""

    episodes: int
    first: int
    """The smallest seed."""
    sums: Mapping[str, float]
    """Sums of the counting columns, and of the regret."""


class Revision(NamedTuple):
    """Numbers of episodes played under one definition."""

    shown: int
    """Number of episodes that belong to the study."""
    there: int
    """Number of all episodes in the store."""


class Answers(NamedTuple):
    """Answers of a student's model, over all its episodes."""

    turns: int
    answers: int
    failures: int
    """Answers that were not actions."""
    truncated: int
    """Answers that were cut at the greatest length."""
    input_tokens: float | None
    """None if an addend is unknown, like the next fields."""
    output_tokens: float | None
    usd: float | None
    seconds: float | None

    def plus(self, other: "Answers") -> "Answers":
        """The sums of both counts."""
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
    """Cumulative regret after each turn, shape (seeds, max_turns); constant after the end of an episode."""


def plan(study: Study) -> Plan:
    """The settings of a study with their seeds; each sample has its own setting."""
    found: dict[EpisodeSpec, list[int]] = {}
    for _, alike in itertools.groupby(study.episodes(), lambda spec: (*spec[:_SEED], *spec[_SEED + 1 :])):
        specs = list(alike)
        found.setdefault(specs[0]._replace(seed=0), []).extend(spec.seed for spec in specs)
    return {setting: tuple(seeds) for setting, seeds in found.items()}


class Columns:
    """The episodes of a study in a store.

    Args:
        db: a connection of its own.
        planned: the settings with their seeds.
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
        """Whether the store has an episode."""
        query = "SELECT 1 FROM result WHERE key = ?"
        return self._db.execute(query, (bytes.fromhex(spec.key),)).fetchone() is not None

    def count(self, seeds: Iterable[int]) -> int:
        """Number of episodes with these seeds."""
        rows = self._db.execute(f"SELECT seed, count(*) FROM {_WANTED} GROUP BY seed")  # noqa: S608 (names of ours)
        chosen = set(seeds)
        return sum(count for seed, count in rows if seed in chosen)

    def sums(self) -> dict[EpisodeSpec, Sums]:
        """Sums by setting; settings without an episode are left out."""
        sums = ", ".join(f"total({_HEDGED if name is Label.HEDGED else name})" for name in _SUMMED)
        query = f"SELECT setting, count(*), min(seed), {sums} FROM {_WANTED} GROUP BY setting"  # noqa: S608
        found: dict[EpisodeSpec, Sums] = {}
        for setting, count, first, *values in self._db.execute(query):
            found[self._there[setting]] = Sums(count, first, dict(zip(_SUMMED, values, strict=True)))
        return found

    def answers(self) -> dict[str, Answers]:
        """The answers of each student that asks a model."""
        sums = ", ".join(f"total({name})" for name in ("turns", "parse_failures", "truncated", "answers"))
        known = ", ".join(f"count({name}) < count(*), total({name})" for name in _COSTS)
        query = f"SELECT setting, {sums}, {known} FROM {_WANTED} WHERE answers IS NOT NULL GROUP BY setting"  # noqa: S608
        found: dict[str, Answers] = {}
        for setting, turns, failures, truncated, answers, *costs in self._db.execute(query):
            own = Answers(
                int(turns),
                int(answers),
                int(failures),
                int(truncated),
                *(None if unknown else total for unknown, total in zip(costs[::2], costs[1::2], strict=True)),
            )
            student = self._there[setting].student
            found[student] = found[student].plus(own) if student in found else own
        return found

    def sampled(self) -> Iterator[dict[str, Any]]:
        """The episodes of a study with several samples, for `llf_teacher.studies.analysis.pass_at_k`."""
        rows = self._db.execute(f"SELECT setting, seed, first_success FROM {_WANTED}")  # noqa: S608 (names of ours)
        for setting, seed, first in rows:
            yield self._there[setting]._asdict() | {"seed": seed, "first_success": first}

    def information(self) -> Iterator[tuple[EpisodeSpec, int, str, NDArray[np.float64]]]:
        """The setting and the seed of each episode, why claims were not measured, and the columns of `INFORMATION`.

        The columns are NaN if they were not measured.
        """
        rows = self._db.execute(
            f"SELECT setting, seed, why, {', '.join(INFORMATION)} "  # noqa: S608 (names of ours)
            f"FROM {_WANTED} JOIN setting USING (setting) ORDER BY setting"
        )
        for setting, seed, why, *values in rows:
            yield self._there[setting], seed, why, np.array(values, float)

    def read_false(self) -> Iterator[tuple[EpisodeSpec, int, str]]:
        """The setting, the seed and the key of each episode with a sentence that was read and is false."""
        said = "read_false + model_false > 0"
        query = f"SELECT setting, seed, lower(hex(key)) FROM {_WANTED} WHERE {said}"  # noqa: S608
        for setting, seed, key in self._db.execute(f"{query} ORDER BY setting, seed"):
            yield self._there[setting], seed, key

    def revisions(self) -> dict[int, Revision]:
        """Number of episodes of each revision in the store, also of other definitions."""
        counts = (
            dict(self._db.execute(f"SELECT revision, count(*) FROM {rows} GROUP BY revision"))  # noqa: S608
            for rows in ("result", _WANTED)
        )
        there, wanted = counts
        return {number: Revision(wanted.get(number, 0), count) for number, count in sorted(there.items())}

    def coded(self) -> Iterator[tuple[frozenset[str], int, int]]:
        """What may have code of its own in some episodes, the revision of these, and their number."""
        query = f"SELECT setting, revision, count(*) FROM {_WANTED} GROUP BY setting, revision"  # noqa: S608
        for setting, revision, number in self._db.execute(query):
            spec = self._there[setting]
            yield frozenset((spec.id, spec.teacher, spec.student, spec.reader, spec.taught)), revision, number

    def failures(self) -> dict[tuple[str, str], int]:
        """Number of failed episodes that were not played later, by student and reason."""
        wanted = {setting: set(seeds) for setting, seeds in self._planned.items()}
        found: Counter[tuple[str, str]] = Counter()
        for seed, reason, *shared in self._db.execute(f"SELECT seed, reason, {_SHARED} FROM failure"):  # noqa: S608
            setting = EpisodeSpec._make((*shared[:_SEED], 0, *shared[_SEED:]))
            if seed in wanted.get(setting, ()):
                found[setting.student, reason] += 1
        return dict(sorted(found.items()))

    def curves(self, order: Iterable[EpisodeSpec]) -> Iterator[Curves]:
        """The settings with episodes, one by one in the given order; others are left out."""
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
        """The outcomes of the episodes, averaged over environments with the same grid."""
        names = "setting, seed, regret, success, coalesce(first_success, 9e999)"
        rows = self._db.execute(f"SELECT {names} FROM {_WANTED} ORDER BY setting")  # noqa: S608 (names of ours)
        tables = {
            self._there[number]: np.array(list(alike)) for number, alike in itertools.groupby(rows, lambda row: row[0])
        }
        ordered = [(spec, tables[spec]) for spec in self._planned if spec in tables]
        return gathered((_column(spec, table) for spec, table in ordered), study.grid)


def _column(spec: EpisodeSpec, table: NDArray[np.float64]) -> Column:
    fields = spec._asdict() | {"family": entry(spec.id).family.name}
    seeds = table[:, 1].astype(np.int64)
    return Column(tuple(fields[name] for name in SETTING), seeds, table[:, 2:], np.full_like(seeds, spec.sample))


_WANTED = "result CROSS JOIN wanted USING (setting) CROSS JOIN seeds USING (list, seed)"  # reads each row once


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
    with reading(store.path) as db:
        db.execute("BEGIN")
        yield Columns(db, planned)
