"""The matrix of students and teachers: the shares of the gain that are due to the teacher and to the student.

The question is that of Cupiał et al. (2026, arXiv 2606.30774): what does a student gain beyond another try, and is that
due to the teacher, to the student, or to their interaction? They found that with language models in both seats the
student matters more. The gain is the regret with the control minus the regret with the teacher on the same seed; its
variance over the table is split as in a two-way layout.
"""

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy import stats

from llf_teacher.studies.analysis.contrasts import can_differ
from llf_teacher.studies.analysis.estimators import bootstrap_seeds
from llf_teacher.studies.analysis.outcomes import Group, Numbers, Outcomes, at_seeds, common_seeds
from llf_teacher.studies.analysis.statistics import Estimate, Split, mean_interval, variance_split
from llf_teacher.studies.analysis.time_to_success import CONTROL


class Matrix(NamedTuple):
    """The gains of one family under one instruction type and feedback type."""

    group: Group
    teachers: tuple[str, ...]
    """All teachers except the control, in descending order of their mean gain over the students."""
    students: tuple[str, ...]
    """The students that teachers can reach."""
    gains: dict[tuple[str, str], Estimate]
    """By teacher and student, in the family's unit."""
    split: Split | None
    """Shares of the variance of gains; None if all are equal."""
    low: Split | None
    """Lower ends of the 95 % intervals, by a bootstrap over seeds; None as `split`, and for a single seed."""
    high: Split | None
    """Upper ends; None as `low`."""
    lead: tuple[float, float] | None
    """Ends of the 95 % interval of the students' share minus the teachers'; None as `low`."""
    order: dict[str, tuple[str, ...]]
    """For each student the teachers, in descending order of their mean gain."""
    agreement: float | None
    """Agreement of the students on the order of teachers: Kendall's W (Kendall & Babington Smith 1939), 0 to 1,
    corrected for ties; None for fewer than three teachers, and if all gains of each student are equal.
    """


def matrices(found: Outcomes, control: str = CONTROL) -> Iterator[Matrix]:
    """A matrix wherever the control and at least two teachers have taught at least two students on the same seeds."""
    for group, cells in found.items():
        students = [s for t, s in cells if t == control and can_differ("oracle", control, s, group.feedback_type)]
        teachers = [t for t in dict.fromkeys(t for t, _ in cells) if t != control]
        teachers = [t for t in teachers if all((t, s) in cells for s in students)]
        if len(students) < 2 or len(teachers) < 2:
            continue
        seeds = common_seeds(*(cells[pair] for pair in product([control, *teachers], students)))
        if not len(seeds):
            continue
        table = np.array(
            [
                [at_seeds(cells[control, s], seeds).regret - at_seeds(cells[t, s], seeds).regret for s in students]
                for t in teachers
            ]
        )  # (teachers, students, seeds)
        means = table.mean(axis=2)
        split = variance_split(table)
        low = high = lead = None
        if split is not None and len(seeds) > 1:
            lows, highs = (ends.tolist() for ends in bootstrap_seeds(table, _shares))
            low, high, lead = Split(*lows[:-1]), Split(*highs[:-1]), (lows[-1], highs[-1])
        yield Matrix(
            group=group,
            teachers=tuple(teachers[i] for i in np.argsort(-means.mean(axis=1), kind="stable")),
            students=tuple(students),
            gains={
                (t, s): mean_interval(table[i, j])
                for (i, t), (j, s) in product(enumerate(teachers), enumerate(students))
            },
            split=split,
            low=low,
            high=high,
            lead=lead,
            order={
                s: tuple(teachers[i] for i in np.argsort(-means[:, j], kind="stable")) for j, s in enumerate(students)
            },
            agreement=_agreement(means),
        )


_NONE = Split(np.nan, np.nan, np.nan, np.nan)


def _shares(table: Numbers) -> tuple[float, ...]:
    """The shares of the variance, and the students' share minus the teachers' share."""
    split = variance_split(table) or _NONE
    return *split, split.students - split.teachers


def _agreement(means: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]") -> float | None:
    """Kendall's W of a table of shape (teachers, students), by Friedman's statistic."""
    teachers, students = means.shape
    if teachers < 3 or not np.ptp(means.round(12), axis=0).any():
        return None
    statistic = stats.friedmanchisquare(*means.round(12)).statistic
    return float(statistic) / (students * (teachers - 1))
