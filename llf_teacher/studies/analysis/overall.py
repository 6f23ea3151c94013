"""One number per teacher over all families, with estimators for many tasks.

A task is a student in a group of environments; a run is a seed, with the score of `scores.symmetric`:
the baseline's regret minus the teacher's, divided by the sum of both mean regrets.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from llf_teacher.studies.analysis.estimators import (
    Profile,
    interquartile_mean,
    performance_profile,
    probability_of_improvement,
)
from llf_teacher.studies.analysis.outcomes import Outcomes
from llf_teacher.studies.analysis.scores import Both, has_ratio, pairs, symmetric
from llf_teacher.studies.analysis.statistics import Estimate

THRESHOLDS = np.linspace(-1, 1, 41)
"""The scores at which a profile has points."""


class Overall(NamedTuple):
    """A teacher over all tasks where it can differ from the baseline."""

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
    """Every teacher with a score under each instruction type and feedback type, in the order of first outcomes."""
    tasks: dict[tuple[str, str, str], list[Both]] = {}
    for compared, families in pairs(found, baseline).items():
        key = compared.teacher, compared.instruction_type, compared.feedback_type
        there = [both for both in families.values() if has_ratio(*(each.regret for each in both))]
        if there:
            tasks.setdefault(key, []).extend(there)
    for key, mine in tasks.items():
        scores = [symmetric(own.regret, other.regret) for own, other in mine]
        regrets = [[-each.regret for each in both] for both in mine]
        yield Overall(
            *key,
            tasks=len(mine),
            middle=interquartile_mean(scores),
            profile=performance_profile(scores, THRESHOLDS),
            better=probability_of_improvement(*zip(*regrets, strict=True)),
        )
