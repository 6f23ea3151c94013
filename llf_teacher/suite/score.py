"""Scores: contrasts in regret in the unit of a reference, with intervals over seeds, and why some are not measured."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from llf_teacher.studies.analysis.statistics import LEAST, mean_interval, paired_difference

Numbers = NDArray[np.float64]
UNREAD = 0.5
"""Share of a student's answers that are no actions, above which its regret says nothing of feedback."""
CEILING = 0.1
"""Share of the reference's regret without help, below which a student has nothing left to save."""
LEVELS = {"unread": UNREAD, "ceiling": CEILING, "seeds": LEAST}
"""The thresholds."""


class Arms(NamedTuple):
    """What was lost in an environment: per seed an array of shape (seeds,), NaN where an episode is missing."""

    better: Numbers
    """By the student with the better teacher."""
    worse: Numbers
    unit_better: Numbers
    """By the reference, with the better teacher of the unit."""
    unit_worse: Numbers
    silent: Numbers | None = None
    """By the student with a silent teacher; None where there is no such arm."""
    unread: Mapping[str, float] = {}
    """By teacher, the share of the student's answers that were no actions."""
    missing: str = ""
    """Why nothing can be played here; empty if it can."""

    def lacks(self, offset: float) -> str:
        """Why nothing can be measured here; empty if it can."""
        unit = self.unit_worse - self.unit_better
        if self.missing:
            return self.missing
        own = [self.better, self.worse, *(() if self.silent is None else (self.silent,))]
        if (lacking := np.isnan(own).any(axis=0)).any():
            return f"{lacking.sum()} of {len(unit)} seeds failed or were not played"
        for teacher, share in self.unread.items():
            if share > UNREAD:
                return f"{share:.0%} of the answers to {teacher} were no actions"
        if len(unit) < LEAST:
            return f"{len(unit)} seeds are too few; at least {LEAST} are needed"
        low = stats.ttest_1samp(unit, 0).confidence_interval(0.95).low if np.ptp(unit) else unit[0]
        if not low > 0:
            return "the reference saves nothing for certain"
        if not offset and self.worse.mean() < CEILING * self.unit_worse.mean():
            return "without help there is nothing left to save"
        return ""


class Score(NamedTuple):
    """The score of a student in an experiment."""

    value: float
    """1: as the reference; 0: no notice is taken; it can be beyond both. NaN if it was not measured."""
    low: float = np.nan
    """Lower end of the 95 % interval; NaN without one."""
    high: float = np.nan
    p: float = np.nan
    """Of the sign-flip test over seeds that there is no contrast."""
    seeds: int = 0
    spread: float = np.nan
    """Standard deviation over seeds of what is tested, in the unit of the score."""
    places: Mapping[str, float] = {}
    """The score in each environment that counts."""
    why: str = ""
    """Why it was not measured, or where it was not."""
    alike: bool | None = None
    """Where both lessons should be alike: whether the interval is within the margin; None elsewhere."""
    silence: "Score | None" = None
    """The same contrast beside silence in place of the worse lessons; None where there is no such arm."""
    moments_p: float = np.nan
    """Of the test that the worse lessons cost as much as silence."""

    @property
    def measured(self) -> bool:
        """Whether there is a score."""
        return bool(np.isfinite(self.value))


def score(arms: Mapping[str, Arms], offset: float = 0.0, margin: float | None = None) -> Score:
    """The mean over environments of the contrast in units, from `offset` on.

    The interval is that of the ratio's linear part by the delta method, so that the noise of the denominator is in it
    (Cochran 1977, section 6.4); it is left out where means of such values have none, see
    `llf_teacher.studies.analysis.statistics`.

    Args:
        arms: what was lost, by environment; all have the same seeds in the same order.
        offset: 0 where the contrast is the ability; 1 where the ability is to have none.
        margin: see `llf_teacher.suite.experiment.Experiment.margin`.
    """
    lacking = {id: why for id, each in arms.items() if (why := each.lacks(offset))}
    why = "; ".join(f"{id}: {each}" for id, each in lacking.items())
    there = {id: each for id, each in arms.items() if id not in lacking}
    if not there:
        return Score(np.nan, why=why)
    found = _contrast(there, offset, margin)
    found = found._replace(why="; ".join(filter(None, (why, found.why))))
    silent = {id: each._replace(worse=each.silent) for id, each in there.items() if each.silent is not None}
    if not silent:
        return found
    moments = {id: each._replace(better=there[id].worse) for id, each in silent.items()}
    return found._replace(silence=_contrast(silent), moments_p=_contrast(moments).p)


def _contrast(there: Mapping[str, Arms], offset: float = 0.0, margin: float | None = None) -> Score:
    """`score` in environments in which nothing lacks."""
    sign = -1.0 if offset else 1.0
    contrasts = np.array([each.worse - each.better for each in there.values()])
    units = np.array([each.unit_worse - each.unit_better for each in there.values()])
    scale = units.mean(axis=1, keepdims=True)
    ratios = contrasts.mean(axis=1, keepdims=True) / scale
    value = float(offset + sign * ratios.mean())
    linear = mean_interval(value + sign * ((contrasts - ratios * units) / scale).mean(axis=0))
    low, high = (linear.low, linear.high) if linear.why != "all equal" else (value, value)
    together = (contrasts / scale).mean(axis=0)
    return Score(
        value,
        low,
        high,
        paired_difference(together, np.zeros_like(together)).p,
        len(together),
        float(together.std(ddof=1)),
        {id: float(offset + sign * ratio) for id, ratio in zip(there, ratios[:, 0], strict=True)},
        linear.why if low != low else "",  # NaN
        None if margin is None else bool(1 - margin < low and high < 1 + margin),
    )
