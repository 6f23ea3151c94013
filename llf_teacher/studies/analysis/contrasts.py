"""Which comparisons of teachers a study tests, at which level, and how small a p-value can be."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, cast

from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.analysis.sequential import ALPHA, levels_of
from llf_teacher.studies.analysis.statistics import RESAMPLES
from llf_teacher.studies.definition.design import InterimAnalyses
from llf_teacher.studies.definition.recalled import student_of, teacher_of
from llf_teacher.studies.definition.study import Study
from teachers.feedback import parse_kinds


class Test(NamedTuple):
    """How a study's comparisons are tested with the episodes that are there."""

    level: float
    """The greatest adjusted p-value that is significant."""
    seeds: frozenset[int]
    """Those that count: all, or those of an interim analysis."""
    analysis: int = 0
    """The interim analysis of a sequential design, counted from 1; 0 without one."""


def test_of(study: Study, is_played: Callable[[frozenset[int]], bool]) -> Test | None:
    """How a study is tested: when it is complete, or at its last complete interim analysis; None before.

    Args:
        study: with its interim analyses, if any.
        is_played: whether all episodes of these seeds have been played.
    """
    seeds = cast(Sequence[int], study.seeds)
    if not study.interim_analyses:
        return Test(ALPHA, frozenset(seeds)) if is_played(frozenset(seeds)) else None
    design = InterimAnalyses(**study.interim_analyses)
    found = None
    for number, (needed, level) in enumerate(zip(design.at, levels_of(design), strict=True), start=1):
        if is_played(frozenset(seeds[:needed])):
            found = Test(level, frozenset(seeds[:needed]), number)
    return found


def can_differ(teacher: str, baseline: str, student: str, feedback_type: str) -> bool:
    """Whether a student can act differently with two teachers.

    It cannot if it hears neither: it ignores teachers, there is no feedback, or both teachers are mute. Such a pair is
    no comparison, and p-values are not adjusted for it.
    """
    if teacher == baseline or student_of(student).reads not in TAUGHT or not parse_kinds(feedback_type):
        return False
    return not (teacher_of(teacher).mute and teacher_of(baseline).mute)


def least_p(seeds: int) -> float:
    """About the smallest p-value that `statistics.paired_difference` can give for a number of pairs.

    It belongs to differences of one sign: two of the 2**n ways to flip signs are as extreme. Beyond
    `statistics.RESAMPLES` ways signs are flipped at random, and the observed signs count as one of these ways (Phipson
    & Smyth 2010).
    """
    if seeds < 1:
        raise ValueError(f"a comparison needs at least one seed, got {seeds}")
    return min(1.0, 2 / 2**seeds) if 2**seeds <= RESAMPLES else 1 / (RESAMPLES + 1)
