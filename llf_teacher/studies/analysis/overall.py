"""One number per teacher over all families, by estimators for many tasks.

A task is a student in a group of environments; a run is a seed. The score of a run is the share of the baseline's mean
regret that the teacher saves: 0 equals the baseline, 1 is perfect, and below 0 the teacher does harm.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from llf_teacher.studies.analysis.contrasts import can_differ
from llf_teacher.studies.analysis.estimators import (
    Profile,
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)
from llf_teacher.studies.analysis.outcomes import Numbers, Outcomes, paired
from llf_teacher.studies.analysis.statistics import Estimate

THRESHOLDS = np.linspace(-1, 1, 41)
"""Scores at which a profile is drawn."""


class Overall(NamedTuple):
    """A teacher over all tasks in which it can differ from the baseline."""

    teacher: str
    instruction_type: str
    feedback_type: str
    tasks: int
    middle: Estimate
    """Interquartile mean of the scores."""
    profile: Profile
    """Share of the runs above each of `THRESHOLDS`."""
    better: Estimate
    """Probability that a run is better than a run with the baseline."""


def overall(found: Outcomes, baseline: str) -> Iterator[Overall]:
    """Every teacher under each instruction type and feedback type, in the order of their first outcomes."""
    scores: dict[tuple[str, str, str], list[tuple[Numbers, Numbers]]] = {}
    for group, cells in found.items():
        for (teacher, student), cell in cells.items():
            other = cells.get((baseline, student))
            if other is None or not can_differ(teacher, baseline, student, group.feedback_type):
                continue
            own, other = paired(cell, other)
            regret = other.regret.mean() if len(other.seeds) else 0.0
            if regret > 0:
                key = teacher, group.instruction_type, group.feedback_type
                both = 1 - own.regret / regret, 1 - other.regret / regret
                scores.setdefault(key, []).append(both)
    for key, tasks in scores.items():
        first, second = zip(*tasks, strict=True)
        yield Overall(
            *key,
            tasks=len(tasks),
            middle=interquartile_mean(first),
            profile=performance_profile(first, THRESHOLDS),
            better=probability_of_improvement(first, second),
        )
