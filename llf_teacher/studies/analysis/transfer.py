"""Transfer: what lessons have left when a student is tested without a teacher, there or elsewhere.

It is told by comparison with students who practised as long with the baseline.
"""

from collections.abc import Iterator
from typing import NamedTuple

from llf_teacher.studies.analysis.outcomes import Group, Outcomes, paired
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval


class AfterLessons(NamedTuple):
    """What came of a test of one teacher's students."""

    group: Group
    """With the lessons' number, environment and worlds, and their feedback type."""
    teacher: str
    """Who taught."""
    student: str
    success: Estimate
    """Share of successes in the test, 0 to 1."""
    regret: Estimate
    """Of the test, in the family's unit."""
    gain: Estimate | None
    """Regret of those who practised as long with the baseline on the same seeds, less this; None without them."""


def tested(found: Outcomes, baseline: str) -> Iterator[AfterLessons]:
    """Every test."""
    for group, cells in found.items():
        for (teacher, student), cell in cells.items() if group.lessons else ():
            other = cells.get((baseline, student))
            gain = None
            if other is not None and teacher != baseline:
                own, others = paired(cell, other)
                gain = mean_interval(others.regret - own.regret) if len(own.seeds) else None
            yield AfterLessons(group, teacher, student, mean_interval(cell.success), mean_interval(cell.regret), gain)
