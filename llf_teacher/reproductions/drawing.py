"""What plots of rows have in common."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.studies.analysis.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def spread(estimates: Sequence[Estimate]) -> list[list[float]]:
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
        axes.bar(places + shift, [each.mean for each in found], width, yerr=spread(found), label=name)
    axes.set_xticks(places, groups)
