"""Plots with intervals, for several rows."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from llf_teacher.studies.analysis.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def line(axes: "Axes", places: Sequence[float], found: Sequence[Estimate], label: str, **style: Any) -> None:
    """A line of means with their intervals.

    Args:
        axes: to draw on.
        places: positions on the horizontal axis.
        found: the estimates.
        label: in the legend.
        style: as of Matplotlib's `errorbar`.
    """
    axes.errorbar(places, [each.mean for each in found], _spread(found), label=label, **style)


def name_lines(figure: "Figure") -> None:
    """Write the label of each line beside its end, in place of a legend."""
    from llf_teacher.studies.report.plots import name_end, separate

    names = []
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            drawn: Any = handle
            if isinstance(handle, tuple):  # a line with its intervals
                drawn = drawn.lines[0]
            end = drawn.get_xydata()[-1]
            names.append(name_end(axes, label, (float(end[0]), float(end[1])), drawn.get_color()))
    separate(figure, names)


def _spread(estimates: Sequence[Estimate]) -> list[list[float]]:
    """The lengths of intervals below and above their means, as Matplotlib takes them."""
    return [[each.mean - each.low for each in estimates], [each.high - each.mean for each in estimates]]


def bars(axes: "Axes", groups: Sequence[str], series: Mapping[str, Sequence[Estimate]]) -> None:
    """Groups of bars with intervals, one bar per series.

    Args:
        axes: to draw on.
        groups: their names.
        series: an estimate per group, by name of the series.
    """
    places, width = np.arange(len(groups)), 0.8 / len(series)
    for number, (name, found) in enumerate(series.items()):
        shift = (number - (len(series) - 1) / 2) * width
        axes.bar(places + shift, [each.mean for each in found], width, yerr=_spread(found), label=name)
    axes.set_xticks(places, groups)
