"""Transfer: what remains of lessons when a student is tested without a teacher, in the same environment or another.

It is measured against students with as many lessons from the baseline.
"""

from collections.abc import Iterator
from typing import NamedTuple

from llf_teacher.studies.analysis.outcomes import Group, Outcomes, paired
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, share_interval


class AfterLessons(NamedTuple):
    """The outcome of tests after lessons from one teacher."""

    group: Group
    """With the lessons' number, environment and worlds, and their feedback type."""
    teacher: str
    """The teacher of the lessons."""
    student: str
    success: Estimate
    """Share of successes in the test, 0 to 1."""
    regret: Estimate
    """Of the test, in the family's unit."""
    gain: Estimate | None
    """Regret after as many lessons from the baseline on the same seeds, minus this; None without them."""


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
