"""Which teachers are worth comparing, and what a comparison can show at all."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, cast

from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import TAUGHT
from llf_teacher.studies.analysis.sequential import ALPHA, levels_of
from llf_teacher.studies.analysis.statistics import RESAMPLES
from llf_teacher.studies.definition.custom_specs import parse_teacher
from llf_teacher.studies.definition.design import InterimAnalyses
from llf_teacher.studies.definition.study import Study
from teachers.feedback import parse_kinds


class Test(NamedTuple):
    """How a study's comparisons are tested now."""

    level: float
    """The greatest adjusted p-value that is a finding."""
    seeds: frozenset[int]
    """Those that count: all, or those of a look."""
    look: int = 0
    """The look of a sequential design, counted from 1; 0 without one."""


def test_of(study: Study, is_played: Callable[[frozenset[int]], bool]) -> Test | None:
    """How a study is tested: when it is whole, or at the last look for which all has been played; None before.

    Args:
        study: with its looks, if any.
        is_played: whether all episodes of some seeds have been.
    """
    seeds = cast(Sequence[int], study.seeds)
    if not study.looks:
        return Test(ALPHA, frozenset(seeds)) if is_played(frozenset(seeds)) else None
    looks = InterimAnalyses(**study.looks)
    found = None
    for number, (needed, level) in enumerate(zip(looks.at, levels_of(looks), strict=True), start=1):
        if is_played(frozenset(seeds[:needed])):
            found = Test(level, frozenset(seeds[:needed]), number)
    return found


def can_differ(teacher: str, baseline: str, student: str, feedback_type: str) -> bool:
    """Whether a student might do otherwise with a teacher than with another, given how they are made.

    It cannot where it hears nothing of either: no teacher reaches it, no feedback is wanted, or both are mute. Such a
    pair is no comparison, and is not counted among those that p-values are adjusted for.
    """
    if teacher == baseline or parse_student(student).reads not in TAUGHT or not parse_kinds(feedback_type):
        return False
    return not (parse_teacher(teacher).mute and parse_teacher(baseline).mute)


def least_p(seeds: int) -> float:
    """About the least p-value that `statistics.paired_difference` can give of so many pairs.

    All differences have the same sign: of the 2**n ways to flip them, two are as extreme. Where signs are flipped at
    random, beyond `statistics.RESAMPLES` ways, the observed one counts as one of them (Phipson & Smyth 2010).
    """
    if seeds < 1:
        raise ValueError(f"a comparison needs at least one seed, got {seeds}")
    return min(1.0, 2 / 2**seeds) if 2**seeds <= RESAMPLES else 1 / (RESAMPLES + 1)
