"""The primary comparisons of a study: each teacher with the baseline, for a student, over all families together.

Families measure regret in different units. In each the difference of a seed is divided by the sum of the mean regrets
of both teachers, and a seed's score is the mean of these over the families that were played with it: 0 is no
difference, 1 a teacher without regret, -1 a teacher with regret beside a baseline without any, and 0.5 a third of the
baseline's regret. Swapping both teachers, in all seeds or in one, keeps the scale and only flips the sign of the score.
So sign flips are exchangeable if the teachers are alike.

A study controls its error rate over these comparisons and its interim analyses.
"""

import math
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.studies.analysis.contrasts import Test, can_differ, least_p, tested
from llf_teacher.studies.analysis.outcomes import Endings, Group, Numbers, Outcomes, paired
from llf_teacher.studies.analysis.power import POWER, Need, need, seeds_needed
from llf_teacher.studies.analysis.sequential import ALPHA
from llf_teacher.studies.analysis.statistics import Difference, holm
from llf_teacher.studies.definition.study import Study


class Compared(NamedTuple):
    """The pair that is compared with the baseline."""

    teacher: str
    student: str
    instruction_type: str
    feedback_type: str


class Primary(NamedTuple):
    """A comparison with the baseline over all families; above 0 the teacher is better."""

    compared: Compared
    declared: bool
    """Whether it is a primary comparison of the study; others are exploratory."""
    families: tuple[Group, ...]
    shares: tuple[float, ...]
    """The mean score in each family."""
    score: Difference
    """The mean over all families; n counts seeds. p is adjusted for interim analyses and, in primary comparisons, by
    Holm's method."""
    spread: float
    """Standard deviation of the scores; NaN for a single seed."""

    @property
    def mean(self) -> float:
        """The mean score."""
        return self.score.estimate.mean

    def more(self, comparisons: int) -> int | None:
        """Additional seeds for a power of 80 % if the true score is the observed one; at least 1.

        Args:
            comparisons: number of primary comparisons.

        Returns:
            None without an observed difference, and for a single seed.
        """
        if not self.mean or not self.spread >= 0:
            return None
        return max(1, seeds_needed(self.mean, self.spread, ALPHA / comparisons, POWER) - self.score.estimate.n)


def symmetric(own: Numbers, other: Numbers) -> Numbers:
    """For each pair the second regret minus the first, divided by the sum of both mean magnitudes.

    Magnitudes, since negated rewards replace regret where no values are known.
    """
    scale = np.abs(own).mean() + np.abs(other).mean()
    scores: Numbers = (other - own) / scale if scale > 0 else np.zeros_like(own)
    return scores


def pairs(found: Outcomes, baseline: str) -> dict[Compared, dict[Group, tuple[Endings, Endings]]]:
    """For each comparison that can differ, and each family, the outcomes of teacher and baseline on common seeds."""
    every: dict[Compared, dict[Group, tuple[Endings, Endings]]] = {}
    differ: dict[Compared, bool] = {}
    for group, cells in found.items():
        for (teacher, student), cell in cells.items():
            other = cells.get((baseline, student))
            key = Compared(teacher, student, group.instruction_type, group.feedback_type)
            if key not in differ:
                differ[key] = can_differ(teacher, baseline, student, group.feedback_type)
            if other is None or not differ[key]:
                continue
            own, others = paired(cell, other)
            if len(own.seeds):
                every.setdefault(key, {})[group] = own, others
    return every


def scores(families: Sequence[tuple[Endings, Endings]], among: frozenset[int] | None = None) -> Numbers:
    """The score of each seed, in ascending order of the seeds.

    Args:
        families: a teacher and the baseline in each family.
        among: the seeds that count; None: all.
    """
    parts = [_kept(each, among) for each in families]
    seeds = np.concatenate([seeds for seeds, *_ in parts]) if parts else np.empty(0, np.int64)
    values = np.concatenate([symmetric(own, other) for _, own, other in parts]) if parts else np.empty(0)
    _, place = np.unique(seeds, return_inverse=True)
    means: Numbers = np.bincount(place, weights=values) / np.bincount(place)
    return means


def _kept(family: tuple[Endings, Endings], among: frozenset[int] | None) -> tuple[NDArray[np.int64], Numbers, Numbers]:
    """The counted seeds, with both regrets."""
    own, other = family
    if among is None or among.issuperset(own.seeds.tolist()):
        return own.seeds, own.regret, other.regret
    counts = np.isin(own.seeds, list(among))
    return own.seeds[counts], own.regret[counts], other.regret[counts]


def primary(
    found: Outcomes, baseline: str, test: Test | None, patterns: Sequence[Mapping[str, str]] = ()
) -> list[Primary]:
    """The comparisons with the baseline, in the order of their first outcomes.

    Args:
        found: the outcomes of episodes with a teacher.
        baseline: the teacher to compare with.
        test: how to test them; None before the first test.
        patterns: the patterns of `Study.primary`.
    """
    among = test.seeds if test else None
    there = {
        key: mine
        for key, families in pairs(found, baseline).items()
        if (mine := {group: each for group, each in families.items() if len(_kept(each, among)[0])})
    }
    every = [list(families.values()) for families in there.values()]
    declared = [_declared(key, patterns) for key in there]
    results = tested(test, lambda among: [scores(families, among) for families in every])
    adjusted = iter(holm([each.p for each, mine in zip(results, declared, strict=True) if mine]))
    return [
        Primary(
            key,
            mine,
            tuple(families),
            tuple(float(scores([each], among).mean()) for each in families.values()),
            result._replace(p=next(adjusted)) if mine else result,
            _spread(scores(list(families.values()), among)),
        )
        for (key, families), mine, result in zip(there.items(), declared, results, strict=True)
    ]


def of_study(found: Outcomes, study: Study, test: Test | None) -> list[Primary]:
    """`primary` of a study."""
    return primary(found, study.baseline, test, study.primary)


def _declared(key: Compared, patterns: Sequence[Mapping[str, str]]) -> bool:
    fields = key._asdict()
    return not patterns or any(
        all(fnmatchcase(fields[name], pattern) for name, pattern in table.items()) for table in patterns
    )


def _spread(values: Numbers) -> float:
    return float(values.std(ddof=1)) if len(values) > 1 else np.nan


def least(comparisons: Sequence[Primary], test: Test) -> float:
    """The smallest possible adjusted p-value for a number of primary comparisons and of seeds."""
    declared = [each for each in comparisons if each.declared]
    seeds = max((each.score.estimate.n for each in declared), default=1)
    return min(1.0, len(declared) * test.adjusted(least_p(seeds)))


def enough(comparisons: int) -> int:
    """The least number of seeds at which one of a number of comparisons can be significant in a single test."""
    return next(seeds for seeds in range(1, 64) if comparisons * 2 / 2**seeds <= ALPHA)


def primary_needs(
    pilot: Outcomes, baseline: str, effect: float, wanted: float = POWER, patterns: Sequence[Mapping[str, str]] = ()
) -> list[Need]:
    """The seeds that every primary comparison of a pilot needs, without comparisons at a single seed.

    Args:
        pilot: the outcomes of its episodes.
        baseline: the teacher to compare with.
        effect: the smallest difference that matters, as a share of the baseline's mean regret.
        wanted: power, 0 to 1.
        patterns: the patterns of `Study.primary`.
    """
    declared = {key: each for key, each in pairs(pilot, baseline).items() if _declared(key, patterns)}
    score = effect / (2 - effect) if effect < 2 else math.inf  # the score of regrets that are less by this share
    found = []
    for key, families in declared.items():
        values, ids = scores(list(families.values())), tuple(id for group in families for id in group.ids)
        if len(values) > 1:
            fields = key.instruction_type, key.feedback_type, key.teacher, key.student
            found.append(need("all", ids, *fields, values, score, len(declared), wanted))
    return found
