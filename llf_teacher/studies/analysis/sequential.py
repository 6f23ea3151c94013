"""Sequential designs: interim analyses of a study that together keep the error rate of 5 %.

A design fixes the numbers of seeds at which a study is analysed. An alpha-spending function (Lan & DeMets 1983), which
resembles the boundary of O'Brien & Fleming (1979) or that of Pocock (1977), spreads the error over the analyses by
their share of the seeds. The level of each analysis follows by recursive integration (Armitage, McPherson & Rowe 1969)
over a statistic with normal increments. A difference is significant if its p-value is at most that level.
"""

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy import integrate, optimize, stats

from llf_teacher.studies.definition.design import SPENDING, InterimAnalyses

ALPHA = 0.05
"""Two-sided error of a whole design."""
_POINTS = 801  # of the grid of integration, an odd number for Simpson's rule
_FAR = 9.0  # standard deviations beyond which the density is 0


def _obrien_fleming(share: float) -> float:
    return float(2 * stats.norm.sf(stats.norm.isf(ALPHA / 4) / math.sqrt(share)))


def _pocock(share: float) -> float:
    return ALPHA / 2 * math.log1p((math.e - 1) * share)


_SPENT = dict(zip(SPENDING, (_obrien_fleming, _pocock), strict=True))
"""By name, the one-sided error that is spent after a share of the seeds."""


def levels_of(design: InterimAnalyses) -> tuple[float, ...]:
    """For each interim analysis, the greatest two-sided p-value that is significant."""
    return levels(tuple(seeds / design.at[-1] for seeds in design.at), design.spending)


@cache
def levels(shares: Sequence[float], spending: str = "obrien_fleming") -> tuple[float, ...]:
    """The two-sided level of each interim analysis.

    Args:
        shares: shares of the seeds at which the study is analysed: ascending, above 0, the last one 1.
        spending: one of `SPENDING`.
    """
    spent = [0.0, *map(_SPENT[spending], shares)]
    found: list[float] = []
    grid = density = np.empty(0)  # of the sum so far, of variance `before`, without a significant result
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

        bound = float(optimize.brentq(lambda z, beyond=beyond, more=more: beyond(z) - more, 0, _FAR, xtol=1e-10))
        found.append(2 * float(stats.norm.sf(bound)))
        points = np.linspace(-1, 1, _POINTS) * bound * math.sqrt(share)
        steps = stats.norm.pdf(points[:, None], grid, spread) if len(grid) else None
        density = stats.norm.pdf(points, scale=spread) if steps is None else integrate.simpson(steps * density, x=grid)
        grid, before = points, share
    return tuple(found)
