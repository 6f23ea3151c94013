"""Transfer: the effect of lessons in a test without a teacher, in the same environment or another.

The comparison is with students after as many lessons from the baseline.
"""

from collections.abc import Iterator
from typing import NamedTuple

from llf_teacher.studies.analysis.outcomes import Group, Outcomes, paired
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, share_interval


class AfterLessons(NamedTuple):
    """The outcome of tests after lessons from one teacher."""

    group: Group
    """The setting, with the lessons' number, environment, worlds and feedback type."""
    teacher: str
    """The teacher of the lessons."""
    student: str
    success: Estimate
    """Share of successes in the test, 0 to 1."""
    regret: Estimate
    """Regret of the test, in the family's unit."""
    gain: Estimate | None
    """Regret after as many lessons from the baseline on the same seeds, minus this regret; None without such lessons.
    """


def tested(found: Outcomes, baseline: str) -> Iterator[AfterLessons]:
    """The outcomes of all tests."""
    for group, cells in found.items():
        for (teacher, student), cell in cells.items() if group.lessons else ():
            other = cells.get((baseline, student))
            gain = None
            if other is not None and teacher != baseline:
                own, others = paired(cell, other)
                gain = mean_interval(others.regret - own.regret) if len(own.seeds) else None
            yield AfterLessons(group, teacher, student, share_interval(cell.success), mean_interval(cell.regret), gain)
