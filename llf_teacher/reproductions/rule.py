"""The rule of a row, which is written before anything is played, and the verdict that all rows share.

A claim expects effects: differences between settings, in a direction, of a smallest size that counts. Each is tested
against that size by a two-sided sign-flip test over seeds (Fisher 1935), and the p-values of a row are adjusted by
Holm's method (1979). So a verdict is wrong in at most 5 % of rows.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from llf_teacher.studies.analysis.statistics import holm

YES, NO, OPEN = VERDICTS = ("yes", "no", "open")
ALPHA = 0.05
"""Probability of a wrong verdict on a row, at most."""
TENTH = 0.1
"""The smallest effect that counts where nothing else is said: a tenth of what the other setting has."""
_RESAMPLES = 9999

Setting = Mapping[str, Any]
"""Keyword arguments of a row's `measure`, JSON values. They must determine a measurement, since results are stored."""
Measured = Callable[..., NDArray[np.float64]]
"""Gives the measures of a setting, shape (seeds, measures)."""


@dataclass(frozen=True, kw_only=True)
class Expectation:
    """An expected effect: what some settings have more than others, paired by seed."""

    expects: str
    """The expectation, in words."""
    more: Sequence[Setting]
    """The settings that are expected to have more; several are added."""
    less: Sequence[Setting] = ()
    """The settings that are expected to have less; several are added, and none is 0."""
    measure: str
    """The name of what is compared."""
    least: float
    """The smallest effect that counts; below 0 it is the greatest loss that does not count."""
    share_of: Setting | None = None
    """The setting of whose measure `least` is a share; None: `least` has the unit of the measure."""

    def effects(self, values: Measured, column: int) -> NDArray[np.float64]:
        """The effect, one number per seed."""
        more = sum(values(**each)[:, column] for each in self.more)
        return np.asarray(more - sum(values(**each)[:, column] for each in self.less))

    def margins(self, values: Measured, column: int) -> NDArray[np.float64]:
        """The smallest effect that counts in the unit of the measure, one number per seed."""
        if self.share_of is None:
            return np.full(len(values(**self.more[0])), self.least)
        return np.asarray(self.least * values(**self.share_of)[:, column])


def saves(expects: str, setting: Setting, than: Setting, measure: str, least: float = TENTH) -> Expectation:
    """The expectation that a setting has less than another, by a share of the latter's."""
    return Expectation(expects=expects, more=(than,), less=(setting,), measure=measure, least=least, share_of=than)


@dataclass(frozen=True, kw_only=True)
class Rule:
    """What is declared before a row is played."""

    seeds: int
    """Number of seeds of each setting."""
    comparisons: Sequence[Expectation]
    """All of them must hold; together they are one family for Holm's method."""


class Judged(NamedTuple):
    """An expectation and its verdict."""

    expectation: Expectation
    effects: NDArray[np.float64]
    """One per seed."""
    least: float
    """The smallest effect that counts in the unit of the measure; where it is a share, the mean over seeds."""
    p: float
    """Of the effect's difference from the least one, after Holm."""
    verdict: str
    """`yes`: significantly above the least effect; `no`: significantly below it; else `open`."""


def judge(rule: Rule, values: Measured, measures: Sequence[str]) -> list[Judged]:
    """The verdict on each expectation of a rule, in order.

    Args:
        rule: the declaration.
        values: what was measured.
        measures: the names of the columns.
    """
    found, beyond = [], []
    for each in rule.comparisons:
        column = measures.index(each.measure)
        effects, margins = each.effects(values, column), each.margins(values, column)
        found.append((each, effects, float(margins.mean())))
        beyond.append(effects - margins)
    adjusted = holm([_p(column) for column in beyond])
    judged = []
    for (expectation, effects, least), above, p in zip(found, beyond, adjusted, strict=True):
        verdict = OPEN if p >= ALPHA else YES if above.mean() > 0 else NO
        judged.append(Judged(expectation, effects, least, p, verdict))
    return judged


def verdict(judged: Sequence[Judged]) -> str:
    """`yes` if every expectation is, `no` if any is, else `open`."""
    verdicts = {each.verdict for each in judged}
    return NO if NO in verdicts else OPEN if OPEN in verdicts else YES


def _p(column: NDArray[np.float64]) -> float:
    """Two-sided p-value of the sign-flip test that a mean is 0, exact where there are at most 13 numbers."""
    if len(column) < 2 or not column.any():
        return 1.0
    found = stats.permutation_test(
        (column,),
        lambda signed, axis: signed.mean(axis=axis),
        permutation_type="samples",
        vectorized=True,
        n_resamples=_RESAMPLES,
        random_state=0,
    )
    return float(found.pvalue)
