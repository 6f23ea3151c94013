"""A section of a report: the results of one family under one instruction type and feedback type."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.analysis import statistics
from llf_teacher.studies.analysis.contrasts import Test, can_differ, tested
from llf_teacher.studies.analysis.estimators import curve_areas
from llf_teacher.studies.analysis.statistics import Band, Difference, Estimate, Split, variance_split
from llf_teacher.studies.definition.stored_specs import is_own, student_of
from llf_teacher.studies.definition.study import Grid
from llf_teacher.studies.report.columns import Curves, Sums
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.plots import MOST, curve_plot, dot_plot
from pz_envs.subject import Subject


class Cell(NamedTuple):
    """One teacher with one student, at the seeds at which every environment of the section was played."""

    seeds: NDArray[np.int64]
    success: NDArray[np.bool_]
    """Success at the last turn, shape (seeds, environments times samples)."""
    regrets: NDArray[np.float64]
    """Cumulative regret at the end, averaged over environments and samples, shape (seeds,)."""
    band: Band
    """Cumulative regret after each turn, averaged over the environments."""
    areas: NDArray[np.float64]
    """Mean height of each seed's curve, shape (seeds,)."""


def cell(curves: Sequence[Curves]) -> Cell | None:
    """A cell from the curves of each environment and sample; None without a common seed."""
    seeds = curves[0].seeds
    for each in curves[1:]:
        seeds = np.intersect1d(seeds, each.seeds, assume_unique=True)
    if not len(seeds):
        return None
    rows = [np.searchsorted(each.seeds, seeds) for each in curves]
    success = np.column_stack([each.success[row] for each, row in zip(curves, rows, strict=True)])
    regrets = np.mean([each.regrets[row] for each, row in zip(curves, rows, strict=True)], axis=0)
    return Cell(seeds, success, regrets[:, -1].copy(), statistics.mean_band(regrets), curve_areas(regrets))


@dataclass(frozen=True, kw_only=True)
class Section:
    """The results of one family under one instruction type and feedback type."""

    family: Subject
    instruction_type: str
    feedback_type: str
    part: int
    """Number of the section among sections of the same family and types with other grids, from 0."""
    ids: tuple[str, ...]
    """Environments with at least one episode."""
    grid: Grid
    """The study's teachers, students and seeds for these environments."""
    cells: Mapping[tuple[str, str], Cell]
    """Cells by teacher and student, without cells that have no complete seed."""
    sums: Mapping[EpisodeSpec, Sums]
    """Sums over all episodes of the section, by setting."""
    reference: str
    """The teacher that the section compares others with."""
    test: Test | None
    """How to test differences; None before the first test."""
    named: Mapping[str, str]
    """The name of each teacher and student, by spec."""
    asked: tuple[str, ...] = ()
    """The teachers that the study asks about, then a user's own: their transcripts come first."""
    chosen: tuple[EpisodeSpec, ...] | None = None
    """Episodes that the study selects for transcripts; None: the report chooses."""

    @property
    def anchor(self) -> str:
        """The section's id within the page."""
        name = f"{self.family.name}-{self.instruction_type}-{self.feedback_type}".replace("+", "-")
        return f"{name}-{self.part}" if self.part else name

    @property
    def digits(self) -> int:
        """Decimals of regrets: 1 if the greatest mean is at least 10, else 2."""
        greatest = max((estimate.mean for estimate in self.regret.values()), default=0)
        return 1 if greatest >= 10 else 2

    @cached_property
    def success(self) -> dict[tuple[str, str], Estimate]:
        """Share of successes, 0 to 1, per cell."""
        return dict(
            zip(self.cells, statistics.success_intervals([c.success for c in self.cells.values()]), strict=True)
        )

    @cached_property
    def regret(self) -> dict[tuple[str, str], Estimate]:
        """Final cumulative regret, in the family's unit, per cell."""
        estimates = statistics.mean_intervals([cell.regrets for cell in self.cells.values()])
        return dict(zip(self.cells, estimates, strict=True))

    def paired(self, teacher: str, student: str, among: Collection[int] | None = None) -> NDArray[np.float64] | None:
        """Regrets with a teacher and with the reference on the same seeds, shape (2, seeds); None without such seeds.

        Args:
            teacher: the teacher, not the reference.
            student: the student of both.
            among: the seeds that count; None: all.
        """
        one, other = self.cells.get((teacher, student)), self.cells.get((self.reference, student))
        if one is None or other is None:
            return None
        seeds, *rows = np.intersect1d(one.seeds, other.seeds, assume_unique=True, return_indices=True)
        if among is not None:
            counts = np.isin(seeds, list(among))
            seeds, rows = seeds[counts], [row[counts] for row in rows]
        return np.array([one.regrets[rows[0]], other.regrets[rows[1]]]) if len(seeds) else None

    @property
    def compared(self) -> list[tuple[str, str]]:
        """The cells that can differ from the same student's cell with the reference."""
        return [pair for pair in self.cells if can_differ(pair[0], self.reference, pair[1], self.feedback_type)]

    @cached_property
    def differences(self) -> dict[tuple[str, str], Difference]:
        """Regret minus the reference's regret on the same seeds, for cells that can differ.

        p-values are adjusted for interim analyses, not yet for the number of comparisons: `Data.secondary` is.
        """
        among = self.test.seeds if self.test else None
        there = [pair for pair in self.compared if self.paired(*pair, among) is not None]

        def differences(seeds: Collection[int] | None) -> list[NDArray[np.float64]]:
            both = (self.paired(*pair, seeds) for pair in there)
            return [np.empty(0) if each is None else each[0] - each[1] for each in both]

        return dict(zip(there, tested(self.test, differences), strict=True))

    @cached_property
    def areas(self) -> dict[tuple[str, str], Estimate]:
        """Area under each cell's curve of cumulative regret, divided by the turns: its mean height."""
        estimates = statistics.mean_intervals([cell.areas for cell in self.cells.values()])
        return dict(zip(self.cells, estimates, strict=True))

    @property
    def plots(self) -> tuple[Plot, Plot]:
        """Success and regret of each cell, and cumulative regret over turns."""
        unit, name, called = self.family.regret_unit, self.family.name, self.called
        names = tuple(map(called, self.grid.teachers)), tuple(map(called, self.grid.students))
        success, regret = (
            {(called(teacher), called(student)): estimate for (teacher, student), estimate in each.items()}
            for each in (self.success, self.regret)
        )
        panels = {
            student: {
                teacher: self.cells[teacher, student].band
                for teacher in self.grid.teachers
                if (teacher, student) in self.cells
            }
            for student in self.grid.students
        }
        labels = {
            f"{called(student)} (reads {reads_words(student)})": {
                called(teacher): band for teacher, band in bands.items()
            }
            for student, bands in panels.items()
        }
        return (
            Plot(
                name=f"{self.anchor}-dots",
                title=f"Success and cumulative regret by teacher and student in {name}; its table has the numbers.",
                draw=lambda width: dot_plot(*names, success, regret, unit, width),
                columns=("teacher", "student", "seeds", *_ends("success"), *_ends("regret")),
                rows=[
                    (*map(called, pair), self.regret[pair].n, *self.success[pair][:3], *self.regret[pair][:3])
                    for pair in self.cells
                ],
            ),
            Plot(
                name=f"{self.anchor}-curves",
                title=f"Mean cumulative regret over turns by teacher, one panel a student, in {name}.",
                draw=lambda width: curve_plot(labels, tuple(map(called, self.drawn)), unit, width),
                columns=("student", "teacher", "turn", *_ends("regret")),
                rows=[
                    (called(student), called(teacher), turn, *map(float, at))
                    for student, bands in panels.items()
                    for teacher, band in bands.items()
                    if teacher in self.drawn
                    for turn, at in enumerate(zip(*band, strict=True), start=1)
                ],
            ),
        )

    def called(self, spec: str) -> str:
        """The name of a teacher or a student."""
        return self.named.get(spec, spec)

    @cached_property
    def drawn(self) -> tuple[str, ...]:
        """The teachers with curves: all, or if they are too many, those of `asked`, the reference and a selection.

        The selection has evenly spaced ranks of the regret of `reader`, including the least and the greatest. Teachers
        are in the order of the study, so that each keeps its colour.
        """
        if len(self.grid.teachers) <= MOST:
            return self.grid.teachers
        first = dict.fromkeys(each for each in (*self.asked, self.reference) if each in self.grid.teachers)
        chosen = set(list(first)[:MOST])
        others = [t for t in self.grid.teachers if t not in chosen and (t, self.reader) in self.cells]
        ranked = sorted(others, key=lambda teacher: self.regret[teacher, self.reader].mean)
        room = min(MOST - len(chosen), len(ranked))
        chosen |= {ranked[rank] for rank in np.linspace(0, len(ranked) - 1, room).round().astype(int)}
        return tuple(teacher for teacher in self.grid.teachers if teacher in chosen)

    @cached_property
    def split(self) -> Split | None:
        """Shares of the variance of regret; None without a common seed of all cells, or if all regrets are equal."""
        pairs = [self.cells.get(pair) for pair in product(self.grid.teachers, self.grid.students)]
        cells = [cell for cell in pairs if cell is not None]
        seeds = set.intersection(*(set(cell.seeds.tolist()) for cell in cells)) if len(cells) == len(pairs) else set()
        if not seeds:
            return None
        regrets = [cell.regrets[np.isin(cell.seeds, list(seeds))] for cell in cells]
        return variance_split(np.reshape(regrets, (len(self.grid.teachers), len(self.grid.students), len(seeds))))

    @cached_property
    def reader(self) -> str:
        """The student of transcripts and examples: if possible one that reads words, otherwise atoms, otherwise any.

        Among equals a user's own comes first.
        """
        there = {setting.student for setting in self.sums}
        played = [student for student in self.grid.students if student in there]
        return min(played, key=lambda student: ((*TAUGHT, reads(student)).index(reads(student)), not is_own(student)))

    def taught(self, teacher: str, student: str) -> dict[EpisodeSpec, Sums]:
        """The sums of a teacher with a student, by setting."""
        return {each: s for each, s in self.sums.items() if (each.teacher, each.student) == (teacher, student)}

    @property
    def arms(self) -> list[str]:
        """The teachers that have taught `reader`, those of `asked` first."""
        order = dict.fromkeys((*self.asked, *self.grid.teachers))
        return [teacher for teacher in order if self.taught(teacher, self.reader)]

    @property
    def transcripts(self) -> list[EpisodeSpec]:
        """The episodes that the study chooses, else the first episode of `reader` with each teacher."""
        if self.chosen is not None:
            return list(self.chosen)
        found = []
        for teacher in self.arms:
            setting, sums = min(self.taught(teacher, self.reader).items())
            found.append(setting._replace(seed=sums.first))
        return found


def _ends(name: str) -> tuple[str, str, str]:
    return name, f"{name}_low", f"{name}_high"


def added(all_sums: Iterable[Sums], name: str) -> float:
    """The sum of a column over settings."""
    return sum(each.sums[name] for each in all_sums)


def share(all_sums: Sequence[Sums], part: str, whole: str) -> float | None:
    """The ratio of the sums of two columns; None if the second is 0."""
    return added(all_sums, part) / total if (total := added(all_sums, whole)) else None


def reads(student: str) -> str:
    """The information that a student reads, one of `llf_teacher.students.student.READS`."""
    return student_of(student).reads


def reads_words(student: str) -> str:
    """What a student reads, in words for people: its atoms are claims with their sentences."""
    return reads(student).replace("atoms", "claims")
