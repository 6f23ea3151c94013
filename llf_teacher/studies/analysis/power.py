"""Power analysis: how many seeds a study needs, from the paired differences of a pilot study.

A comparison of a teacher with the baseline is a test of paired differences. Its power is computed for the paired
t-test, with the noncentral t distribution (Cohen 1988), which the sign-flip test approaches (Hoeffding 1952), at the
level of the first step of Holm's method over all comparisons. Since the standard deviation of a pilot is uncertain, the
number of seeds is also given for the upper end of its one-sided 80 % interval (Browne 1995).
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy import optimize, stats

from llf_teacher.studies.analysis.outcomes import Numbers, Outcomes
from llf_teacher.studies.analysis.scores import Compared, has_ratio, pairs, symmetric
from teachers.spec import unknown

ALPHA, POWER = 0.05, 0.8
MOST = 1_000_000
"""The greatest number of seeds that the search considers."""
_CONFIDENCE = 0.8
MEASURES = ("score", "regret", "success")
"""The measures of an effect: the score of the findings, a difference of regrets in the family's unit, or one of success
rates, 0 to 1."""


class Need(NamedTuple):
    """The seeds that one comparison needs."""

    family: str
    ids: tuple[str, ...]
    instruction_type: str
    feedback_type: str
    teacher: str
    student: str
    other: str
    """The teacher that the first is compared with."""
    pairs: int
    """Seeds of the pilot."""
    spread: float
    """Standard deviation of the paired differences."""
    seeds: int
    """Seeds that give the wanted power if `spread` is the true one."""
    safe: int
    """The same for the upper end of the spread's interval."""


def power(seeds: int, effect: float, spread: float, alpha: float = ALPHA) -> float:
    """Power of a two-sided paired t-test.

    Args:
        seeds: number of pairs, at least 2.
        effect: the true mean difference.
        spread: the true standard deviation of the differences, above 0.
        alpha: level of the test.
    """
    shift, bound = abs(effect) / spread * math.sqrt(seeds), stats.t.isf(alpha / 2, seeds - 1)
    found, lost = stats.nct.sf(bound, seeds - 1, shift), stats.nct.cdf(-bound, seeds - 1, shift)
    return 1.0 if math.isnan(found) else float(found + np.nan_to_num(lost))  # far out SciPy gives NaN for 1 and 0


def least_effect(seeds: int, spread: float, alpha: float = ALPHA, wanted: float = POWER) -> float:
    """The least true mean difference that is detected with about the wanted power; infinite if there are too few seeds.

    The p-values of few sign flips are coarse: the level is the greatest p-value that they reach, and if only the most
    extreme one is small enough, all differences must have the same sign. Arguments as in `power`; 0 without spread.
    """
    ways = math.floor(alpha * 2.0 ** (seeds - 1))
    if not ways:
        return math.inf
    if spread <= 0:
        return 0.0
    reached = ways / 2.0 ** (seeds - 1)

    def lacks(effect: float) -> float:
        return wanted - power(seeds, effect, 1.0, reached)

    most = 1.0
    while lacks(most) > 0:
        most *= 2
    one_sign = float(stats.norm.ppf(wanted ** (1 / seeds))) if ways == 1 else 0.0
    return spread * max(one_sign, float(optimize.brentq(lacks, 0.0, most)))


def seeds_needed(effect: float, spread: float, alpha: float = ALPHA, wanted: float = POWER) -> int:
    """The least number of seeds that gives the wanted power and allows p-values of at most alpha; at most `MOST`.

    Arguments as in `power`; without spread only the p-values count.
    """
    low = max(2, math.ceil(math.log2(2 / alpha)))  # two of the 2**n ways to flip signs are most extreme
    if spread <= 0:
        return low

    def enough(seeds: int) -> bool:
        found = power(seeds, effect, spread, alpha)
        return not found < wanted  # far out, where SciPy gives NaN, the power is 1

    high = low
    while high < MOST and not enough(high):
        low, high = high, 2 * high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if enough(middle) else (middle, high)
    return min(high, MOST)


def needs(
    pilot: Outcomes,
    baseline: str,
    effect: float,
    measure: str = "score",
    wanted: float = POWER,
    compare: Sequence[Sequence[str]] = (),
) -> Iterator[Need]:
    """The seeds that every comparison in a family of a pilot needs, without comparisons at a single seed.

    Comparisons are left out in which both teachers are equal at every seed: their spread says nothing. By the score,
    those are left out, too, where the other teacher leaves too little regret for one.

    Args:
        pilot: the outcomes of its episodes.
        baseline: the teacher to compare with.
        effect: the smallest difference that matters, in the measure's unit.
        measure: one of `MEASURES`.
        wanted: power, 0 to 1.
        compare: the pairs of `Study.compare`.

    Raises:
        ValueError: there is no such measure.
    """
    if measure not in MEASURES:
        raise ValueError(unknown("measure", measure, MEASURES))
    every = [(key, *each) for key, families in pairs(pilot, baseline, compare).items() for each in families.items()]
    for key, group, (cell, other) in every:
        if len(cell.seeds) < 2 or (measure == "score" and not has_ratio(cell.regret, other.regret)):
            continue
        differences = {
            "score": symmetric(cell.regret, other.regret),
            "regret": other.regret - cell.regret,
            "success": cell.success - other.success,
        }
        if differences[measure].any():
            yield need(group.family, group.ids, key, differences[measure], effect, len(every), wanted)


def equal(pilot: Outcomes, baseline: str, measure: str, compare: Sequence[Sequence[str]] = ()) -> int:
    """Number of comparisons in a family in which both teachers are equal at each of several seeds.

    Arguments as in `needs`; by the score, regrets are compared.
    """
    column = "success" if measure == "success" else "regret"
    every = (both for families in pairs(pilot, baseline, compare).values() for both in families.values())
    return sum(
        len(own.seeds) > 1 and np.array_equal(getattr(own, column), getattr(other, column)) for own, other in every
    )


def need(
    family: str,
    ids: tuple[str, ...],
    compared: Compared,
    differences: Numbers,
    effect: float,
    comparisons: int,
    wanted: float = POWER,
) -> Need:
    """The seeds that one comparison needs.

    Args:
        family: the family of the comparison.
        ids: its environments.
        compared: the teachers and the student.
        differences: the differences at two or more seeds of the pilot.
        effect: the smallest mean difference that matters.
        comparisons: number of comparisons that are tested together.
        wanted: power, 0 to 1.
    """
    n, spread = len(differences), float(np.std(differences, ddof=1))
    above = spread * math.sqrt((n - 1) / stats.chi2.ppf(1 - _CONFIDENCE, n - 1))
    seeds, safe = (seeds_needed(effect, each, ALPHA / comparisons, wanted) for each in (spread, above))
    fields = compared.instruction_type, compared.feedback_type, compared.teacher, compared.student, compared.other
    return Need(family, ids, *fields, n, spread, seeds, safe)
