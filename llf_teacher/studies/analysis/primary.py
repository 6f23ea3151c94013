"""The primary comparisons of a study: of two teachers, for a student, over all families together by their score.

They are those that the study's `compare` names; without any, each teacher with the baseline, or those of `primary`. A
study controls its error rate over these comparisons and its interim analyses.
"""

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.studies.analysis.contrasts import Test, least_p, tested
from llf_teacher.studies.analysis.outcomes import Group, Numbers, Outcomes
from llf_teacher.studies.analysis.power import POWER, Need, need, seeds_needed
from llf_teacher.studies.analysis.scores import Both, Compared, has_ratio, pairs, symmetric
from llf_teacher.studies.analysis.sequential import ALPHA
from llf_teacher.studies.analysis.statistics import Difference, Estimate, holm, mean_intervals
from llf_teacher.studies.definition.study import Study


class Primary(NamedTuple):
    """A comparison of two teachers over all families; above 0 the first is better."""

    compared: Compared
    declared: bool
    """Whether it is a primary comparison of the study; others are exploratory."""
    families: tuple[Group, ...]
    shares: tuple[float, ...]
    """The mean score in each family."""
    regrets: tuple[tuple[float, float], ...]
    """The mean regrets with both teachers in each family, in its unit."""
    differences: tuple[Estimate, ...]
    """The mean regret with the first teacher minus that with the other in each family, in its unit."""
    ratios: tuple[bool, ...]
    """Whether the score has a meaning in each family: see `scores.has_ratio`."""
    score: Difference
    """The mean over all families; n counts seeds. p is adjusted for interim analyses and, in primary comparisons, by
    Holm's method."""
    spread: float
    """Standard deviation of the scores; NaN for a single seed."""

    @property
    def mean(self) -> float:
        """The mean score."""
        return self.score.estimate.mean

    @property
    def ratio(self) -> bool:
        """Whether the score has a meaning in every family."""
        return all(self.ratios)

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


def scores(families: Sequence[Both], among: frozenset[int] | None = None) -> Numbers:
    """The score of each seed, in ascending order of the seeds; their mean is that of the families' mean scores.

    So a family with fewer seeds than others weighs as much as they do, each of its seeds more.

    Args:
        families: both teachers in each family.
        among: the seeds that count; None: all.
    """
    parts = [part for each in families if len((part := kept(each, among))[0])]
    if not parts:
        return np.empty(0)
    seeds, place = np.unique(np.concatenate([seeds for seeds, *_ in parts]), return_inverse=True)
    values = np.concatenate([symmetric(own, other) * (len(seeds) / len(own)) for _, own, other in parts])
    means: Numbers = np.bincount(place, weights=values) / len(parts)
    return means


def kept(family: Both, among: frozenset[int] | None) -> tuple[NDArray[np.int64], Numbers, Numbers]:
    """The counted seeds, with both regrets."""
    own, other = family
    if among is None or among.issuperset(own.seeds.tolist()):
        return own.seeds, own.regret, other.regret
    counts = np.isin(own.seeds, list(among))
    return own.seeds[counts], own.regret[counts], other.regret[counts]


def primary(
    found: Outcomes,
    baseline: str,
    test: Test | None,
    patterns: Sequence[Mapping[str, str]] = (),
    compare: Sequence[Sequence[str]] = (),
) -> list[Primary]:
    """The comparisons of a study: those of `compare` first, then in the order of their first outcomes.

    Args:
        found: the outcomes of episodes with a teacher.
        baseline: the teacher to compare with.
        test: how to test them; None before the first test.
        patterns: the patterns of `Study.primary`.
        compare: the pairs of `Study.compare`.
    """
    among = test.seeds if test else None
    there = {
        key: mine
        for key, families in pairs(found, baseline, compare).items()
        if (mine := {group: each for group, each in families.items() if len(kept(each, among)[0])})
    }
    every = [list(families.values()) for families in there.values()]
    declared = [_declared(key, patterns, compare) for key in there]
    results = tested(test, lambda among: [scores(families, among) for families in every])
    adjusted = iter(holm([each.p for each, mine in zip(results, declared, strict=True) if mine]))
    regrets = [[kept(family, among)[1:] for family in families] for families in every]
    differences = iter(mean_intervals([own - other for families in regrets for own, other in families]))
    return [
        Primary(
            key,
            mine,
            tuple(families),
            tuple(float(symmetric(*both).mean()) for both in both_regrets),
            tuple((float(own.mean()), float(other.mean())) for own, other in both_regrets),
            tuple(next(differences) for _ in both_regrets),
            tuple(has_ratio(*both) for both in both_regrets),
            result._replace(p=next(adjusted)) if mine else result,
            _spread(scores(list(families.values()), among)),
        )
        for (key, families), mine, both_regrets, result in zip(there.items(), declared, regrets, results, strict=True)
    ]


def of_study(found: Outcomes, study: Study, test: Test | None) -> list[Primary]:
    """`primary` of a study."""
    return primary(found, study.baseline, test, study.primary, study.compare)


def _declared(key: Compared, patterns: Sequence[Mapping[str, str]], compare: Sequence[Sequence[str]]) -> bool:
    if compare:
        return (key.teacher, key.other) in map(tuple, compare)
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
    pilot: Outcomes,
    baseline: str,
    effect: float,
    wanted: float = POWER,
    patterns: Sequence[Mapping[str, str]] = (),
    compare: Sequence[Sequence[str]] = (),
) -> list[Need]:
    """The seeds that every primary comparison of a pilot needs.

    Left out are those at a single seed, without a ratio, and with the same regret in every seed.

    Args:
        pilot: the outcomes of its episodes.
        baseline: the teacher to compare with.
        effect: the smallest score that matters.
        wanted: power, 0 to 1.
        patterns: the patterns of `Study.primary`.
        compare: the pairs of `Study.compare`.
    """
    every = pairs(pilot, baseline, compare).items()
    declared = {key: list(each.items()) for key, each in every if _declared(key, patterns, compare)}
    found = []
    for key, families in declared.items():
        values = scores([both for _, both in families])
        if (
            len(values) > 1
            and values.any()
            and all(has_ratio(own.regret, other.regret) for _, (own, other) in families)
        ):
            ids = tuple(id for group, _ in families for id in group.ids)
            found.append(need("all", ids, key, values, effect, len(declared), wanted))
    return found
