"""Scores: what a teacher saves beside another, as a share of both regrets, so that families have one scale.

In each family the difference of a seed is divided by the sum of the mean regrets of both teachers, and a seed's score
is the mean of these over the families, where a family that was played with every third seed counts threefold: so the
mean over seeds is the mean over families. 0 is no difference, 1 a teacher without regret, and 0.5 a third of the
other's regret. Swapping both teachers, in all seeds or in one, keeps the scale and only flips the
sign of the score. So sign flips are exchangeable if the teachers are alike.

A score says how much only where the other teacher leaves regret: against one that leaves almost none, every teacher
scores about -1. `has_ratio` is the rule; where it fails, differences are given in the family's unit alone.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from llf_teacher.studies.analysis.contrasts import can_differ
from llf_teacher.studies.analysis.outcomes import Endings, Group, Numbers, Outcomes, paired

RATIO, ERRORS = 0.05, 2.0
"""A score needs a mean regret with the other teacher of at least this share of the first one's, and a mean sum of both
of at least so many of its standard errors."""


class Compared(NamedTuple):
    """Two teachers of a student."""

    teacher: str
    student: str
    instruction_type: str
    feedback_type: str
    other: str
    """The teacher that the first is compared with, for example the baseline."""


Both = tuple[Endings, Endings]
"""The outcomes of a teacher and of the other on the same seeds."""
Pairs = dict[Compared, dict[Group, Both]]


def symmetric(own: Numbers, other: Numbers) -> Numbers:
    """For each pair the second regret minus the first, divided by the sum of both mean magnitudes.

    Magnitudes, since negated rewards replace regret where no values are known.
    """
    scale = np.abs(own).mean() + np.abs(other).mean()
    scores: Numbers = (other - own) / scale if scale > 0 else np.zeros_like(own)
    return scores


def has_ratio(own: Numbers, other: Numbers) -> bool:
    """Whether the mean of the other regrets is well away from 0, so that a share of it has a meaning."""
    mine, size = np.abs(own), np.abs(other)
    error = (mine + size).std(ddof=1) / np.sqrt(len(size)) if len(size) > 1 else 0.0
    mean, least = size.mean(), RATIO * mine.mean()
    return bool(mean > 0 and mean >= least and mine.mean() + mean >= ERRORS * error)


def pairs(found: Outcomes, baseline: str, compare: Iterable[Sequence[str]] = ()) -> Pairs:
    """For each comparison that can differ, and each family, the outcomes of both teachers on common seeds.

    Args:
        found: the outcomes of episodes with a teacher.
        baseline: the teacher to compare all others with.
        compare: more pairs of teachers, which come first; a pair with the baseline is then not given the other way
            round, too.
    """
    wanted = dict.fromkeys((one, other) for one, other in compare)
    every: Pairs = {}
    differ: dict[Compared, bool] = {}
    for group, cells in found.items():
        against = [(teacher, baseline) for teacher, _ in cells if (baseline, teacher) not in wanted]
        students = dict.fromkeys(student for _, student in cells)
        for one, other in dict.fromkeys((*wanted, *against)):
            for student in students:
                if (one, student) not in cells or (other, student) not in cells:
                    continue
                key = Compared(one, student, group.instruction_type, group.feedback_type, other)
                if key not in differ:
                    differ[key] = can_differ(one, other, student, group.feedback_type)
                if differ[key]:
                    own, others = paired(cells[one, student], cells[other, student])
                    if len(own.seeds):
                        every.setdefault(key, {})[group] = own, others
    return every
