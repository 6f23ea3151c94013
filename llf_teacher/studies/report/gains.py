"""Gains over all families: the share of regret that a teacher saves a student.

Families measure regret in different units. A share compares them: how much of the same student's mean regret with the
baseline, on the same seeds, the teacher saves. 1 is all of it, 0 is none, and below 0 the teacher does harm.
"""

from collections import defaultdict
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from llf_teacher.studies.analysis.resampling import bootstrap_means
from llf_teacher.studies.analysis.statistics import LEVEL, Estimate
from llf_teacher.studies.report.section import Section

_RESAMPLES = 1999


class Gain(NamedTuple):
    """The gain of a student with a teacher."""

    estimate: Estimate
    """Mean of the families' shares, with the percentile interval of the stratified bootstrap over seeds within
    families; n counts families.
    """
    sections: tuple[Section, ...]
    shares: tuple[float, ...]
    """The share of each section."""


def gains(sections: Sequence[Section]) -> dict[tuple[str, str], Gain]:
    """Gains by teacher and student; sections in which the student has no regret with the baseline are left out."""
    found: dict[tuple[str, str], list[tuple[Section, float, NDArray[np.float64]]]] = defaultdict(list)
    for stratum, section in enumerate(sections, start=1):
        paired = {
            pair: both
            for pair in section.compared
            if (both := section.paired(*pair)) is not None and both[1].mean() > 0
        }
        for seeds in sorted({both.shape[1] for both in paired.values()}):
            alike = {pair: both for pair, both in paired.items() if both.shape[1] == seeds}
            table = np.concatenate(list(alike.values())).T  # columns alternate: teacher, baseline
            drawn = _shares(bootstrap_means(table, _RESAMPLES, stratum))
            if seeds == 1:
                drawn[:] = np.nan
            for pair, share, shares in zip(alike, _shares(table.mean(axis=0)), drawn.T, strict=True):
                found[pair].append((section, float(share), shares))
    return {pair: _gain(parts) for pair, parts in found.items()}


def _shares(means: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shares of saved regret, from columns that alternate teacher and baseline; NaN if the baseline has no regret."""
    own, other = means[..., ::2], means[..., 1::2]
    return 1 - np.divide(own, other, out=np.full_like(own, np.nan), where=other > 0)


def _gain(parts: Sequence[tuple[Section, float, NDArray[np.float64]]]) -> Gain:
    sections, shares, drawn = zip(*parts, strict=True)
    samples = np.mean(drawn, axis=0)
    there = samples[~np.isnan(samples)]
    low, high = np.quantile(there, ((1 - LEVEL) / 2, (1 + LEVEL) / 2)).tolist() if len(there) else (np.nan, np.nan)
    return Gain(Estimate(float(np.mean(shares)), low, high, len(parts)), sections, shares)
