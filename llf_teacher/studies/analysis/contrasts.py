"""How a study's comparisons of teachers are tested, and how small a p-value can be.

A study has one error rate of 5 % over its primary comparisons and its interim analyses together: each comparison has a
p-value that is adjusted for the analyses (`sequential.adjusted`), and Holm's method adjusts these for the comparisons.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, cast

import numpy as np

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.analysis.sequential import ALPHA, adjusted
from llf_teacher.studies.analysis.statistics import RESAMPLES, Difference, Numbers, paired_differences
from llf_teacher.studies.definition.design import InterimAnalyses
from llf_teacher.studies.definition.stored_specs import student_of, teacher_of
from llf_teacher.studies.definition.study import Study
from teachers.feedback import parse_kinds


class Test(NamedTuple):
    """How to test a study's comparisons with the played episodes."""

    seeds: frozenset[int]
    """The seeds that count: all, or those of the last complete interim analysis."""
    analysis: int = 0
    """The interim analysis of a sequential design, counted from 1; 0 without one."""
    earlier: tuple[frozenset[int], ...] = ()
    """The seeds of the interim analyses before that one."""
    design: InterimAnalyses | None = None
    """All interim analyses; None without."""

    @property
    def level(self) -> float:
        """The greatest adjusted p-value that is significant."""
        return ALPHA

    def adjusted(self, p: float, analysis: int | None = None) -> float:
        """A p-value of an analysis, by default the last complete one, adjusted for the number of analyses."""
        return adjusted(p, analysis or self.analysis, self.design) if self.design else p


def test_of(study: Study, is_played: Callable[[frozenset[int]], bool]) -> Test | None:
    """How to test a study that is complete, or at its last complete interim analysis; None before.

    Args:
        study: the study; it may have interim analyses.
        is_played: tells whether all episodes of some seeds have been played.
    """
    seeds = cast(Sequence[int], study.seeds)
    if not study.interim_analyses:
        return Test(frozenset(seeds)) if is_played(frozenset(seeds)) else None
    design = InterimAnalyses(**study.interim_analyses)
    waves = [frozenset(seeds[:needed]) for needed in design.at]
    last = max((number for number, wave in enumerate(waves, start=1) if is_played(wave)), default=0)
    return Test(waves[last - 1], last, tuple(waves[: last - 1]), design) if last else None


def tested(test: Test | None, differences: Callable[[frozenset[int] | None], Sequence[Numbers]]) -> list[Difference]:
    """Mean differences with p-values, adjusted for interim analyses, not yet for the number of comparisons.

    Args:
        test: None before the first test; p-values then have no meaning.
        differences: gives for some seeds, or for all by None, the paired differences of each comparison.
    """
    found = paired_differences(differences(test.seeds if test else None))  # each has a seed
    if test is None or test.design is None:
        return found
    least = [test.adjusted(each.p) for each in found]
    for number, seeds in enumerate(test.earlier, start=1):
        before = paired_differences([each if len(each) else np.zeros(1) for each in differences(seeds)])
        least = [min(p, test.adjusted(each.p, number)) for p, each in zip(least, before, strict=True)]
    return [each._replace(p=p) for each, p in zip(found, least, strict=True)]


def can_differ(teacher: str, baseline: str, student: str, feedback_type: str) -> bool:
    """Whether a student can act differently with two teachers.

    It cannot if it hears neither of them: it ignores teachers, there is no feedback, or both teachers are mute. Such a
    pair is not a comparison, and does not count for the adjustment of p-values.
    """
    if teacher == baseline or student_of(student).reads not in TAUGHT or not parse_kinds(feedback_type):
        return False
    return not (teacher_of(teacher).mute and teacher_of(baseline).mute)


def least_p(seeds: int) -> float:
    """About the smallest p-value that `statistics.paired_difference` can give for a number of pairs.

    It occurs if all differences have the same sign: two of the 2**n ways to flip signs are as extreme. Beyond
    `statistics.RESAMPLES` ways signs are flipped at random, and the observed signs count as one way (Phipson & Smyth
    2010).
    """
    if seeds < 1:
        raise ValueError(f"a comparison needs at least one seed, got {seeds}")
    return min(1.0, 2 / 2**seeds) if 2**seeds <= RESAMPLES else 1 / (RESAMPLES + 1)
