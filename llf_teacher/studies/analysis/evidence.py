"""Whether the data of a comparison are evidence: of a difference, of none, or of neither.

yes: the comparison is significant, adjusted for all primary comparisons and interim analyses.
no: it is not, and the data exclude a difference that is not small: the 95 % interval of the score lies within `SMALL`
of 0, or the regrets are the same in all seeds, which are enough for a test.
not decided: all else; also before the test, at an interim analysis, and with too few seeds for a test.
"""

from enum import StrEnum
from typing import NamedTuple

from llf_teacher.studies.analysis.contrasts import Test, least_p
from llf_teacher.studies.analysis.primary import Primary
from llf_teacher.studies.analysis.scores import Pairs
from llf_teacher.studies.analysis.statistics import Estimate, holm, paired_differences

SMALL = 0.1
"""The greatest score that counts as no difference: the greater regret is then 22 % more than the other."""


class Evidence(StrEnum):
    """Whether there is a difference."""

    YES = "yes"
    NO = "no"
    OPEN = "not decided"


class PairEvidence(NamedTuple):
    """What the data say about a comparison."""

    evidence: Evidence
    why: str
    """Why nothing is decided; empty if something is."""
    against: tuple[str, ...]
    """Families whose difference is significant the other way than the whole, adjusted for families and comparisons; if
    the whole is not significant, those in which the first teacher is better."""
    along: tuple[str, ...]
    """The other families with a significant difference."""


def finding(each: Primary, comparisons: int, test: Test | None, pairs: Pairs) -> PairEvidence:
    """What the data say about a primary comparison.

    Args:
        each: the comparison.
        comparisons: number of primary comparisons.
        test: how it is tested; None before the first test.
        pairs: the outcomes of all comparisons.
    """
    if test is None:
        return PairEvidence(Evidence.OPEN, "nothing is tested before all episodes have been played", (), ())
    estimate, yes = each.score.estimate, each.score.p <= test.level
    less, more = _significant(each, comparisons, test, pairs)
    against, along = (less, more) if not yes or each.mean < 0 else (more, less)
    if yes:
        return PairEvidence(Evidence.YES, "", against, along)
    if test.design and test.analysis < len(test.design.at):
        why = f"the study goes on after interim analysis {test.analysis} of {len(test.design.at)}"
        return PairEvidence(Evidence.OPEN, why, (), ())
    if min(1.0, comparisons * test.adjusted(least_p(estimate.n))) > test.level:
        return PairEvidence(
            Evidence.OPEN,
            f"{estimate.n} seed{' is' if estimate.n == 1 else 's are'} too few for any difference to be significant",
            (),
            (),
        )
    same = estimate.why == "all equal" and not estimate.mean
    if same or is_small(estimate):
        return PairEvidence(Evidence.NO, "", against, along)
    if estimate.why:
        why = f"the difference is not significant, and has no interval ({estimate.why})"
    else:
        why = "the difference is not significant, and the interval allows for one that is not small"
    return PairEvidence(Evidence.OPEN, why, against, along)


def is_small(score: Estimate) -> bool:
    """Whether the interval of a score excludes a difference that is not small."""
    return -SMALL <= score.low <= score.high <= SMALL


def _significant(each: Primary, comparisons: int, test: Test, pairs: Pairs) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The families with a significant difference: those with less regret with the first teacher, and with more.

    By Holm's method over the families, times the number of comparisons: each of these names its own families.
    """
    if len(each.families) < 2:
        return (), ()
    both = [pairs[each.compared][group] for group in each.families]
    columns = [(own.regret - other.regret)[[seed in test.seeds for seed in own.seeds]] for own, other in both]
    found = paired_differences(columns)
    named = [
        (group.family, difference.estimate.mean)
        for group, difference, p in zip(each.families, found, holm([each.p for each in found]), strict=True)
        if comparisons * p <= test.level
    ]
    return tuple(name for name, mean in named if mean < 0), tuple(name for name, mean in named if mean > 0)
