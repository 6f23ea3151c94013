"""Sequential designs: interim analyses of a study that together keep the error rate of 5 %.

A design fixes the numbers of seeds at which a study is analysed. An alpha-spending function (Lan & DeMets 1983), which
resembles the boundary of O'Brien & Fleming (1979) or that of Pocock (1977), spreads the error over the analyses by
their share of the seeds. The level of each analysis follows by recursive integration (Armitage, McPherson & Rowe 1969)
over a statistic with normal increments. The p-value of a difference after several analyses is the least error of a
design that would have found it (`adjusted`). It is as valid as the p-value of a single test, so Holm's method over such
p-values controls the error rate over all comparisons and analyses together.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy import integrate, interpolate, optimize, stats

from llf_teacher.studies.definition.design import SPENDING, InterimAnalyses

ALPHA = 0.05
"""Two-sided error of a whole design."""
_POINTS = 401  # of the grid of integration, an odd number for Simpson's rule
_FAR = 9.0  # standard deviations beyond which the density is 0
_ERRORS = np.concatenate([np.geomspace(1e-6, ALPHA, 21), np.geomspace(ALPHA, 0.95, 13)[1:]])
"""The errors of the designs that `adjusted` interpolates."""


def _obrien_fleming(share: float, alpha: float) -> float:
    return float(2 * stats.norm.sf(stats.norm.isf(alpha / 4) / math.sqrt(share)))


def _pocock(share: float, alpha: float) -> float:
    return alpha / 2 * math.log1p((math.e - 1) * share)


_SPENT = dict(zip(SPENDING, (_obrien_fleming, _pocock), strict=True))
"""By name, the one-sided error spent after a share of the seeds, for a design's two-sided error."""


def levels_of(design: InterimAnalyses) -> tuple[float, ...]:
    """For each interim analysis, the greatest two-sided p-value that is significant."""
    return levels(_shares(design), design.spending)


def adjusted(p: float, analysis: int, design: InterimAnalyses) -> float:
    """The least error of a design with these analyses and this spending in which a p-value is significant.

    Args:
        p: two-sided p-value at one analysis.
        analysis: its number, counted from 1.
        design: with all analyses.

    Returns:
        At most `ALPHA` exactly if p is at most the level of that analysis; not below 1e-6, and 1 above 0.95.
    """
    if len(design.at) == 1:
        return p
    least, greatest, log_error = _errors(_shares(design), design.spending)[analysis - 1]
    if p > greatest:
        return 1.0
    return math.exp(log_error(math.log(max(p, least))))


def _shares(design: InterimAnalyses) -> tuple[float, ...]:
    return tuple(seeds / design.at[-1] for seeds in design.at)


@cache
def _errors(shares: tuple[float, ...], spending: str) -> list[tuple[float, float, interpolate.PchipInterpolator]]:
    """For each analysis its least and greatest level in designs of `_ERRORS`, and the logarithm of the error by that of
    the level.
    """  # noqa: D205
    found = np.array([levels(shares, spending, float(error)) for error in _ERRORS])
    table = []
    for column in found.T:
        level, last = np.unique(column[::-1], return_index=True)  # the greatest error among equal levels
        error = np.log(_ERRORS[::-1][last])
        curve = interpolate.PchipInterpolator(np.log(level), error) if len(level) > 1 else None
        table.append((float(level[0]), float(level[-1]), curve or (lambda _, only=error[0]: only)))
    return table


@cache
def levels(shares: Sequence[float], spending: str = "obrien_fleming", alpha: float = ALPHA) -> tuple[float, ...]:
    """The two-sided level of each interim analysis.

    Args:
        shares: shares of the seeds at which the study is analysed: ascending, above 0, the last one 1.
        spending: one of `SPENDING`.
        alpha: two-sided error of the whole design, 0 to 1.
    """
    spent = [0.0, *(_SPENT[spending](share, alpha) for share in shares)]
    found: list[float] = []
    grid = density = np.empty(0)  # density of the sum so far, of variance `before`, without a significant result
    before = 0.0
    for share, more in zip(shares, np.diff(spent), strict=True):
        spread = math.sqrt(share - before)

        def beyond(
            bound: float,
            share: float = share,
            spread: float = spread,
            grid: Any = grid,
            density: Any = density,
        ) -> float:
            if not len(grid):
                return float(stats.norm.sf(bound))
            above = stats.norm.sf((bound * math.sqrt(share) - grid) / spread)
            return float(integrate.simpson(density * above, x=grid))

        bound = _FAR
        if beyond(bound) < more:
            bound = float(optimize.brentq(lambda z, beyond=beyond, more=more: beyond(z) - more, 0, _FAR, xtol=1e-10))
        found.append(2 * float(stats.norm.sf(bound)))
        points = np.linspace(-1, 1, _POINTS) * bound * math.sqrt(share)
        steps = stats.norm.pdf(points[:, None], grid, spread) if len(grid) else None
        density = stats.norm.pdf(points, scale=spread) if steps is None else integrate.simpson(steps * density, x=grid)
        grid, before = points, share
    return tuple(found)
