"""Figures of several panels: dots with intervals, each family in its own unit, and performance profiles."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from llf_teacher.studies.analysis.statistics import Band, Estimate
from llf_teacher.studies.report.plots import MARKERS, SERIES, WIDTH, folded, legend, named, tallest, ticks
from llf_teacher.theme import SHADES

_BESIDE = 2  # panels in a row


class Pane(NamedTuple):
    """One panel of `panel_plot`."""

    title: str
    unit: str
    """Of its axis."""
    dots: Mapping[tuple[str, str], Estimate]
    """By row and series; what is missing stays blank."""


def panel_plot(panels: Sequence[Pane], rows: Sequence[str], series: Sequence[str], label: str) -> Figure:
    """A dot with its interval per row and series, beside a line at 0; panels share rows and series, not the axis.

    Args:
        panels: at least one.
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        label: what is shown, in the unit of each panel.
    """
    columns = min(_BESIDE, len(panels))
    height = math.ceil(len(panels) / columns)
    pitch = max(0.22, 0.1 * len(series) + 0.04, tallest(rows))
    figure = Figure(figsize=(WIDTH, (pitch * len(rows) + 0.75) * height + 0.5))
    grid = figure.subplots(height, columns, sharey=True, squeeze=False).flatten()
    offsets = (np.arange(len(series)) - (len(series) - 1) / 2) * min(0.2, 0.8 / len(series))
    for ax, panel in zip(grid, panels, strict=False):
        for row in range(1, len(rows), 2):
            ax.axhspan(row - 0.5, row + 0.5, color=SHADES["stripe"].light, linewidth=0, zorder=0)
        ax.axvline(0, color=SHADES["ink"].light, linewidth=1)
        for name, offset, color, marker in zip(series, offsets, cycle(SERIES), cycle(MARKERS), strict=False):
            there = [(i + offset, panel.dots[row, name]) for i, row in enumerate(rows) if (row, name) in panel.dots]
            ys = [y for y, _ in there]
            ax.hlines(ys, [e.low for _, e in there], [e.high for _, e in there], color, linewidth=1.6, alpha=0.55)
            dots = ax.plot([e.mean for _, e in there], ys, marker, color=color, label=named(name))[0]
            dots.set_in_layout(False)  # without data it would have no extent, which the layout cannot bear
        ax.set_title(textwrap.fill(panel.title, 100 // columns), loc="left", color=SHADES["ink"].light)
        ax.set_xlabel(f"{label} ({panel.unit})")
        ax.xaxis.set_major_locator(ticks())
        ax.grid(axis="x")
        ax.set_axisbelow(True)
    for ax in grid[len(panels) :]:
        ax.set_axis_off()
    grid[0].set_ylim(len(rows) - 0.5, -0.5)
    grid[0].set_yticks(range(len(rows)), [folded(row) for row in rows])
    for ax in grid[:: len(grid) // height]:
        ax.tick_params(axis="y", labelcolor=SHADES["ink"].light)
    legend(figure, grid[0], 1.0)
    return figure


def profile_plot(profiles: Mapping[str, tuple[Sequence[float], Band]]) -> Figure:
    """Performance profiles: the share of the runs above a score, a line and a band each.

    Args:
        profiles: scores and shares, 0 to 1, by label.
    """
    figure = Figure(figsize=(WIDTH, 3.4))
    ax = figure.subplots()
    for (name, (scores, band)), color, marker in zip(profiles.items(), cycle(SERIES), cycle(MARKERS), strict=False):
        ax.fill_between(scores, band.low, band.high, color=color, alpha=0.15, linewidth=0)
        ax.plot(scores, band.mean, color=color, marker=marker, markevery=5, label=named(name))
    ax.axvline(0, color=SHADES["ink"].light, linewidth=1)
    ax.set_ylim(0, 1)
    ax.margins(x=0)
    ax.xaxis.set_major_formatter(PercentFormatter(1))
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.set_xlabel("share of the baseline's mean regret that the student is spared")
    ax.set_ylabel("runs above it")
    ax.grid()
    ax.set_axisbelow(True)
    legend(figure, ax, 2.2)
    return figure
