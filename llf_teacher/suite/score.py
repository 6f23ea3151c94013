"""Scores: contrasts in regret in the unit of a reference, with intervals over seeds, and why some are not measured."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from llf_teacher.studies.analysis.statistics import LEAST, LEVEL, RESAMPLES, mean_interval, p_words, paired_difference

Numbers = NDArray[np.float64]
ALPHA = 0.05
"""Level of the tests of a card."""
UNREAD = 0.5
"""Greatest share of answers that are not actions; above it regret says nothing about feedback."""
CEILING = 0.1
"""Least share of the reference's regret without help; below it a student has nothing left to save."""
LEVELS = (ALPHA, UNREAD, CEILING, LEAST, LEVEL, RESAMPLES)
"""The thresholds, and the settings of intervals and tests."""


class Arms(NamedTuple):
    """Regrets in an environment: arrays with a value per seed, shape (seeds,), NaN without the episode."""

    better: Numbers
    """The student's regret with the better teacher."""
    worse: Numbers
    unit_better: Numbers
    """The reference's regret with the unit's better teacher."""
    unit_worse: Numbers
    silent: Numbers | None = None
    """The student's regret with a silent teacher; None without such lessons."""
    unread: Mapping[str, float] = {}
    """By teacher, the share of the student's answers that were not actions."""
    missing: str = ""
    """Why nothing can be played here; empty if it can."""

    def lacks(self, margin: float | None) -> str:
        """Why nothing can be measured here; empty if it can."""
        if self.missing:
            return self.missing
        own = [self.better, self.worse, *(() if self.silent is None else (self.silent,))]
        if (lacking := np.isnan(own).any(axis=0)).any():
            return f"{lacking.sum()} of {len(self.better)} seeds failed or were not played"
        if min(self.unread.values(), default=0.0) > UNREAD:
            return f"{np.mean([*self.unread.values()]):.0%} of the answers were no actions"
        for teacher, share in self.unread.items():
            if share > UNREAD:
                return f"{share:.0%} of the answers to {teacher} were no actions"
        if len(self.better) < LEAST:
            return f"{len(self.better)} seeds are too few; at least {LEAST} are needed"
        if not _positive(self.unit_worse - self.unit_better):
            return "not even the scripted student gains significantly here"
        if margin is not None and self.silent is not None and not _positive(self.silent - self.better):
            return "it does not gain significantly by the teacher, compared with silence, so it has no gain to lose"
        if margin is None and self.worse.mean() < CEILING * self.unit_worse.mean():
            return "it does well without help, so that there is nothing to gain"
        return ""


def _positive(saved: Numbers) -> bool:
    """Whether the mean is above 0 by Student's interval."""
    return bool((stats.ttest_1samp(saved, 0).confidence_interval(0.95).low if np.ptp(saved) else saved[0]) > 0)


@dataclass(frozen=True, kw_only=True)
class Score:
    """The score of a student in an experiment."""

    score: float | None = None
    """1: as the reference; 0: no notice is taken; other values are possible. None if it was not measured."""
    low: float | None = None
    """Ends of the 95 % interval; None without one."""
    high: float | None = None
    p: float | None = None
    """p-value of the sign-flip test over seeds that both lessons cost the same; on a card after Holm's correction."""
    why: str = ""
    """Why, or where, it was not measured, or why there is no interval."""

    seeds: int = 0
    spread: float = 0.0
    """Standard deviation over seeds of the tested contrast, in the unit of the score."""
    places: Mapping[str, float] = field(default_factory=dict)
    """The score in each environment that counts."""
    alike: bool | None = None
    """For abilities to take no notice: whether the interval is within the margin; otherwise None."""
    silence: "Score | None" = None
    """The same contrast with silence in place of the worse lessons; None without lessons in silence."""
    moments_p: float | None = None
    """p-value of the test that the worse lessons cost as much as silence."""

    sign: ClassVar[str] = ""
    """The format of signs."""

    @property
    def words(self) -> str:
        """The score as text."""
        if self.score is None:
            return f"not measured: {self.why}"
        if self.low is None or self.high is None:
            return f"{self.score:{self.sign}.2f} (no interval: {self.why})"
        return f"{self.score:{self.sign}.2f} [{self.low:{self.sign}.2f}, {self.high:{self.sign}.2f}]"

    @property
    def chance(self) -> str:
        """The p-value as text; empty without one."""
        return p_words(self.p)

    @property
    def above(self) -> bool:
        """Whether the score is significantly above 0."""
        least = self.score if self.low is None else self.low
        return (least or 0) > 0 and self.p is not None and self.p < ALPHA


def score(arms: Mapping[str, Arms], margin: float | None = None) -> Score:
    """The mean over environments of the contrast in units, subtracted from 1 if there is a margin.

    The interval uses the ratio's linear part by the delta method, and so includes the noise of the denominator (Cochran
    1977, section 6.4); it is omitted if means of such values have no interval, see
    `llf_teacher.studies.analysis.statistics`.

    Args:
        arms: the regrets by environment; all have the same seeds in the same order.
        margin: see `llf_teacher.suite.experiment.Experiment.margin`.
    """
    lacking = {id: why for id, each in arms.items() if (why := each.lacks(margin))}
    why = "; ".join(f"{id}: {each}" for id, each in lacking.items())
    there = {id: each for id, each in arms.items() if id not in lacking}
    if not there:
        return Score(why=why)
    found = _contrast(there, margin, why)
    silent = {id: each._replace(worse=each.silent) for id, each in there.items() if each.silent is not None}
    if margin is not None or not silent:
        return found
    moments = {id: each._replace(better=there[id].worse) for id, each in silent.items()}
    return replace(found, silence=_contrast(silent), moments_p=_contrast(moments).p)


def _contrast(there: Mapping[str, Arms], margin: float | None = None, why: str = "") -> Score:
    """`score` in environments with complete data."""
    sign, offset = (1.0, 0.0) if margin is None else (-1.0, 1.0)
    contrasts = np.array([each.worse - each.better for each in there.values()])
    units = np.array([each.unit_worse - each.unit_better for each in there.values()])
    scale = units.mean(axis=1, keepdims=True)
    ratios = contrasts.mean(axis=1, keepdims=True) / scale
    value = float(offset + sign * ratios.mean())
    linear = mean_interval(value + sign * ((contrasts - ratios * units) / scale).mean(axis=0))
    low, high = (linear.low, linear.high) if linear.why != "all equal" else (value, value)
    bounded = low == low  # no NaN
    together = (contrasts / scale).mean(axis=0)
    return Score(
        score=value,
        low=low if bounded else None,
        high=high if bounded else None,
        p=paired_difference(together, np.zeros_like(together)).p,
        why="; ".join(filter(None, (why, "" if bounded else linear.why))),
        seeds=len(together),
        spread=float(together.std(ddof=1)),
        places={id: float(offset + sign * ratio) for id, ratio in zip(there, ratios[:, 0], strict=True)},
        alike=None if margin is None else bool(1 - margin < low and high < 1 + margin),
    )
