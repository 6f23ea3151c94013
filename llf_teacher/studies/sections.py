"""What a store holds of a study, gathered for its report: sections, their cells, and what teachers said."""

import sqlite3
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import TAUGHT
from llf_teacher.studies import statistics
from llf_teacher.studies.episode import unpack_regrets
from llf_teacher.studies.plots import curve_plot, dot_plot
from llf_teacher.studies.statistics import Difference, Estimate, Split, variance_split
from llf_teacher.studies.study import Grid, Study
from pz_envs.family import Family, all_families
from teachers.atoms import KINDS, Label

REFERENCE = "silent"
"""The teacher that others are compared with."""
CHECKED = (Label.TRUTHFUL, Label.LATE, Label.PLACEBO, Label.DISTORTED)
"""Labels of claims; text without claims does not occur in studies."""
_CURVES = 8
"""Curves in a panel that can be told apart."""


class Played(NamedTuple):
    """An episode as the report needs it."""

    row: sqlite3.Row
    """As `Store.episodes` gives it."""
    curve: NDArray[np.float64]
    """Cumulative regret after each turn, shape (max_turns,); it stays as it is after the end."""
    said: Counter[str]
    """Number of claims by kind."""
    labels: Counter[str]
    """Number of claims by label."""


class Cell(NamedTuple):
    """One teacher with one student: the seeds for which every environment of the section has been played."""

    seeds: tuple[int, ...]
    success: NDArray[np.bool_]
    """Success at the last turn, shape (seeds, environments)."""
    curves: NDArray[np.float64]
    """Cumulative regret averaged over the environments, shape (seeds, max_turns)."""

    @property
    def regrets(self) -> NDArray[np.float64]:
        """Cumulative regret at the end, shape (seeds,)."""
        return self.curves[:, -1]


@dataclass(frozen=True, kw_only=True)
class Section:
    """What a study says of one family under one instruction type and feedback type."""

    family: Family
    instruction_type: str
    feedback_type: str
    ids: tuple[str, ...]
    """Environments that have been played at all."""
    grid: Grid
    """The teachers, students and seeds that the study has for them."""
    cells: Mapping[tuple[str, str], Cell]
    """By teacher and student; one without a complete seed is missing."""
    episodes: tuple[Played, ...]

    part: int
    """Counts the sections of the same family and types from 0: environments with other grids are told apart."""

    @property
    def anchor(self) -> str:
        """The section's id within the page."""
        name = f"{self.family.name}-{self.instruction_type}-{self.feedback_type}".replace("+", "-")
        return f"{name}-{self.part}" if self.part else name

    @property
    def digits(self) -> int:
        """Decimals for regrets: three figures of the greatest mean."""
        greatest = max((estimate.mean for estimate in self.regret.values()), default=0)
        return 1 if greatest >= 10 else 2

    @cached_property
    def success(self) -> dict[tuple[str, str], Estimate]:
        """Share of successes, 0 to 1, per cell."""
        return {key: statistics.success_interval(cell.success) for key, cell in self.cells.items()}

    @cached_property
    def regret(self) -> dict[tuple[str, str], Estimate]:
        """Final cumulative regret, in the family's unit, per cell."""
        return {key: statistics.mean_interval(cell.regrets) for key, cell in self.cells.items()}

    @cached_property
    def differences(self) -> dict[tuple[str, str], Difference]:
        """Regret less that under `REFERENCE` on the same seeds, for students whom teachers can reach; p-values are
        adjusted for the number of these differences.
        """  # noqa: D205
        found = {}
        for (teacher, student), cell in self.cells.items():
            other = self.cells.get((REFERENCE, student))
            if teacher == REFERENCE or other is None or reads(student) not in TAUGHT:
                continue
            seeds = [seed for seed in cell.seeds if seed in other.seeds]
            if seeds:
                pair = (c.regrets[[c.seeds.index(seed) for seed in seeds]] for c in (cell, other))
                found[teacher, student] = statistics.paired_difference(*pair)
        adjusted = statistics.holm([difference.p for difference in found.values()])
        return {key: found[key]._replace(p=p) for key, p in zip(found, adjusted, strict=True)}

    @property
    def dots(self) -> str:
        """Plot of success and regret, as SVG."""
        names = self.grid.teachers, self.grid.students
        return dot_plot(*names, self.success, self.regret, self.family.regret_unit, f"{self.anchor}-d")

    @property
    def curves(self) -> str:
        """Plot of cumulative regret over turns, as SVG."""
        panels = {
            label(student): {
                teacher: statistics.mean_band(self.cells[teacher, student].curves)
                for teacher in self.drawn
                if (teacher, student) in self.cells
            }
            for student in self.grid.students
        }
        return curve_plot(panels, self.drawn, self.family.regret_unit, f"{self.anchor}-c")

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """The teachers whose curves are drawn: all, or if they are too many to be told apart, `REFERENCE` and others
        from the one with whom the regret of `reader` is least to the one with whom it is greatest, evenly spread.
        """  # noqa: D205
        if len(self.grid.teachers) <= _CURVES:
            return self.grid.teachers
        others = [t for t in self.grid.teachers if t != REFERENCE and (t, self.reader) in self.cells]
        ranked = sorted(others, key=lambda teacher: self.regret[teacher, self.reader].mean)
        room = min(_CURVES - (REFERENCE in self.grid.teachers), len(ranked))
        chosen = {ranked[rank] for rank in np.linspace(0, len(ranked) - 1, room).round().astype(int)} | {REFERENCE}
        return tuple(teacher for teacher in self.grid.teachers if teacher in chosen)

    @cached_property
    def split(self) -> Split | None:
        """How the variance of regret splits between teachers and students; None unless every cell has been played."""
        pairs = [self.cells.get(pair) for pair in product(self.grid.teachers, self.grid.students)]
        cells = [cell for cell in pairs if cell is not None]
        seeds = set.intersection(*(set(cell.seeds) for cell in cells)) if len(cells) == len(pairs) else set()
        if not seeds:
            return None
        regrets = [[r for seed, r in zip(cell.seeds, cell.regrets, strict=True) if seed in seeds] for cell in cells]
        return variance_split(np.reshape(regrets, (len(self.grid.teachers), len(self.grid.students), len(seeds))))

    @cached_property
    def reader(self) -> str:
        """The student to look at closely: one who reads words if any, else atoms, else any."""
        played = [student for student in self.grid.students if any(e.row["student"] == student for e in self.episodes)]
        return min(played, key=lambda student: (*TAUGHT, reads(student)).index(reads(student)))

    @cached_property
    def contrast(self) -> tuple[str, ...]:
        """Two teachers of `reader`: of the truthful ones the one with whom regret is least, and the one whose claims
        hold least. If all are truthful, the second is the one with whom regret is greatest; if one has played, it.
        """  # noqa: D205
        ranks = {}
        for teacher in self.grid.teachers:
            taught = [e for e in self.episodes if (e.row["teacher"], e.row["student"]) == (teacher, self.reader)]
            if taught:
                ranks[teacher] = (share_held(taught), -np.mean([episode.curve[-1] for episode in taught]))
        spoke = [teacher for teacher, (held, _) in ranks.items() if held is not None] or list(ranks)
        order = sorted(spoke, key=lambda teacher: ranks[teacher], reverse=True)
        return tuple(dict.fromkeys((order[0], order[-1])))

    @property
    def transcripts(self) -> list[Played]:
        """The first episode of `reader` with each teacher of `contrast`."""
        pairs = [(teacher, self.reader) for teacher in self.contrast]
        return [next(e for e in self.episodes if (e.row["teacher"], e.row["student"]) == pair) for pair in pairs]


class Account(NamedTuple):
    """What a teacher said, over all episodes of some sections."""

    teacher: str
    episodes: int
    per_turn: dict[str, float]
    """Claims per turn of the student, by kind; what is said at the opening counts."""
    labels: dict[str, float]
    """Share of the claims by label; none if there are no claims."""
    uptake: float | None
    """Of the turns before which a student who can be reached was advised an action, the share in which it took one;
    None if there are none.
    """
    words: float
    """Words of feedback per turn of the student."""
    parse_failures: int
    """Answers of students that were no action."""
    turns: int


def reads(student: str) -> str:
    """What a student learns from, one of `llf_teacher.students.student.READS`."""
    return parse_student(student).reads


def label(student: str) -> str:
    """A student's spec and what it reads."""
    return f"{student} (reads {reads(student)})"


def share_held(episodes: Iterable[Played]) -> float | None:
    """Share of the claims of episodes that hold, 0 to 1; None if there are none."""
    counts = [(episode.row["claims_held"], episode.row["claims"]) for episode in episodes]
    held, said = (sum(count) for count in zip(*counts, strict=True)) if counts else (0, 0)
    return held / said if said else None


def played(row: sqlite3.Row) -> Played:
    """What a report needs of an episode."""
    regrets = np.zeros(row["max_turns"])
    regrets[: row["turns"]] = unpack_regrets(row["regrets"])
    return Played(
        row,
        np.cumsum(regrets),
        Counter({kind: row[f"said_{kind}"] for kind in KINDS}),
        Counter({label: row[label] for label in CHECKED}),
    )


def sections(study: Study, episodes: Sequence[Played]) -> Iterator[Section]:
    """A study's sections, in the order of families, types and grids; those without an episode are left out."""
    pairs = product(study.instruction_types, study.feedback_types)
    for family, (instruction_type, feedback_type) in product(all_families(), pairs):
        group = (family.name, instruction_type, feedback_type)
        mine = [e for e in episodes if (e.row["family"], e.row["instruction_type"], e.row["feedback_type"]) == group]
        ids = [id for id in study.ids if any(episode.row["id"] == id for episode in mine)]
        for part, grid in enumerate(dict.fromkeys(map(study.grid, ids))):
            alike = tuple(id for id in ids if study.grid(id) == grid)
            members = [episode for episode in mine if episode.row["id"] in alike]
            cells = {}
            for teacher, student in product(grid.teachers, grid.students):
                cell = _cell([e for e in members if (e.row["teacher"], e.row["student"]) == (teacher, student)], alike)
                if cell.seeds:
                    cells[teacher, student] = cell
            yield Section(
                family=family,
                instruction_type=instruction_type,
                feedback_type=feedback_type,
                ids=alike,
                grid=grid,
                part=part,
                cells=cells,
                episodes=tuple(members),
            )


def _cell(episodes: Iterable[Played], ids: Sequence[str]) -> Cell:
    table = {(episode.row["seed"], episode.row["id"]): episode for episode in episodes}
    seeds = tuple(seed for seed in sorted({seed for seed, _ in table}) if all((seed, id) in table for id in ids))
    complete = [[table[seed, id] for id in ids] for seed in seeds]
    return Cell(
        seeds,
        np.array([[bool(episode.row["success"]) for episode in row] for row in complete]),
        np.array([np.mean([episode.curve for episode in row], axis=0) for row in complete]),
    )


def accounts(study: Study, episodes: Sequence[Played]) -> Iterator[Account]:
    """What each teacher said over all episodes; teachers without an episode are left out."""
    for teacher in study.teachers:
        mine = [episode for episode in episodes if episode.row["teacher"] == teacher]
        if not mine:
            continue
        turns = sum(episode.row["turns"] for episode in mine)
        said = sum((episode.said for episode in mine), Counter())
        labels = sum((episode.labels for episode in mine), Counter())
        reached = [episode for episode in mine if episode.row["reads"] in TAUGHT]
        advised = sum(episode.row["advised"] for episode in reached)
        yield Account(
            teacher=teacher,
            episodes=len(mine),
            per_turn={kind: said[kind] / turns for kind in KINDS},
            labels={label: labels[label] / labels.total() for label in CHECKED} if labels.total() else {},
            uptake=sum(episode.row["followed"] for episode in reached) / advised if advised else None,
            words=sum(episode.row["words"] for episode in mine) / turns,
            parse_failures=sum(episode.row["parse_failures"] for episode in mine),
            turns=turns,
        )
