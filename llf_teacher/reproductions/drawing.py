"""What plots of rows have in common."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from llf_teacher.studies.analysis.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def line(axes: "Axes", places: Sequence[float], found: Sequence[Estimate], label: str, **style: Any) -> None:
    """A line of means with their intervals.

    Args:
        axes: to draw on.
        places: where on the horizontal axis each estimate stands.
        found: the estimates.
        label: what the legend calls it.
        style: as of Matplotlib's `errorbar`.
    """
    axes.errorbar(places, [each.mean for each in found], _spread(found), label=label, **{"marker": "o"} | style)


def _spread(estimates: Sequence[Estimate]) -> list[list[float]]:
    """How far intervals reach below and above their means, as Matplotlib wants it."""
    return [[each.mean - each.low for each in estimates], [each.high - each.mean for each in estimates]]


def bars(axes: "Axes", groups: Sequence[str], series: Mapping[str, Sequence[Estimate]]) -> None:
    """Bars with intervals, a group beside the other, in each a bar of every series.

    Args:
        axes: to draw on.
        groups: their names.
        series: by its name, an estimate per group.
    """
    places, width = np.arange(len(groups)), 0.8 / len(series)
    for number, (name, found) in enumerate(series.items()):
        shift = (number - (len(series) - 1) / 2) * width
        axes.bar(places + shift, [each.mean for each in found], width, yerr=_spread(found), label=name)
    axes.set_xticks(places, groups)
