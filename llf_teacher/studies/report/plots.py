"""The plots of a report, by Matplotlib.

Series differ in markers, too, so that no plot depends on colour alone.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence
from itertools import cycle
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from llf_teacher.studies.analysis.statistics import Band, Estimate
from llf_teacher.theme import SHADES

SERIES = [shade.light for name, shade in SHADES.items() if name.startswith("series")]
"""The colours of series."""
MARKERS = "osD^vPX"
"""One fewer than colours, so that more pairs of both differ."""
_STRIPE = 8.0  # points
_BESIDE = 2  # panels in a row
WIDTH = 10.0
"""Width of figures in inches; the page scales them."""
_NARROW = 4.1  # width in inches for a phone, where letters then are as large as beside a wide figure
STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": SHADES["muted"].light,
    "axes.labelcolor": SHADES["muted"].light,
    "axes.labelsize": 9,
    "axes.spines.left": False,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "figure.constrained_layout.h_pad": 0.07,
    "figure.constrained_layout.use": True,
    "font.size": 9,
    "grid.color": SHADES["rule"].light,
    "grid.linewidth": 0.7,
    "legend.borderpad": 0,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "legend.labelcolor": SHADES["ink"].light,
    "lines.dash_capstyle": "butt",
    "lines.linewidth": 1.5,
    "lines.markersize": 4.4,
    "lines.scale_dashes": False,
    "lines.solid_capstyle": "round",
    "svg.fonttype": "none",
    "svg.hashsalt": "llf",
    "text.color": SHADES["ink"].light,
    "text.parse_math": False,
    "xtick.color": SHADES["muted"].light,
    "ytick.color": SHADES["muted"].light,
    "ytick.left": False,
}
"""Matplotlib's parameters for drawing and saving."""


def _intervals(
    ax: Axes,
    rows: Sequence[str],
    series: Sequence[str],
    estimates: Mapping[tuple[str, str], Estimate],
    *,
    spacing: float = 0.2,
    at_zero: bool = False,
    marks: Mapping[tuple[str, str], Sequence[float]] | None = None,
    line: Mapping[str, Any] = MappingProxyType({"linewidth": 1.6, "alpha": 0.55}),
    **dot: Any,
) -> None:
    """Draw a dot with its interval per row and series, on alternating stripes.

    Args:
        ax: to draw on.
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        estimates: by (row, series); missing ones are blank.
        spacing: greatest distance of two series, in rows.
        at_zero: whether there is a line at 0.
        marks: values of (row, series) that are drawn faintly behind the dots.
        line: style of intervals.
        dot: style of dots.
    """
    for row in range(1, len(rows), 2):
        ax.axhspan(row - 0.5, row + 0.5, color=SHADES["stripe"].light, linewidth=0, zorder=0)
    if at_zero:
        ax.axvline(0, color=SHADES["ink"].light, linewidth=1)
    offsets = (np.arange(len(series)) - (len(series) - 1) / 2) * min(spacing, 0.8 / len(series))
    for name, offset, color, marker in zip(series, offsets, cycle(SERIES), cycle(MARKERS), strict=False):
        pairs = {(row, name): i + offset for i, row in enumerate(rows) if (row, name) in estimates}
        if marks is not None:
            points = [(value, y) for pair, y in pairs.items() for value in marks[pair]]
            ax.plot(*zip(*points, strict=True), "|", color=color, alpha=0.35, markersize=6, clip_on=False)
        ys, found = list(pairs.values()), [estimates[pair] for pair in pairs]
        ax.hlines(ys, [e.low for e in found], [e.high for e in found], color, **line)
        dots = ax.plot([e.mean for e in found], ys, marker, color=color, label=named(name), **dot)[0]
        dots.set_in_layout(False)  # without data they have no extent, which breaks the layout
    ax.grid(axis="x")


def _label_rows(ax: Axes, rows: Sequence[str]) -> None:
    """Name the rows, the first one at the top."""
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_yticks(range(len(rows)), [folded(row) for row in rows], color=SHADES["ink"].light)


def dot_plot(
    rows: Sequence[str],
    series: Sequence[str],
    success: Mapping[tuple[str, str], Estimate],
    regret: Mapping[tuple[str, str], Estimate],
    unit: str,
) -> Figure:
    """Success and final cumulative regret side by side: a dot with its interval per row and series.

    Args:
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        success: shares, 0 to 1, by (row, series); missing ones are blank.
        regret: cumulative regrets in `unit`, by (row, series).
        unit: of regret.
    """
    pitch = max(0.36, 0.1 * len(series) + 0.04, tallest(rows))
    figure = Figure(figsize=(WIDTH, pitch * len(rows) + 1.0))
    axes = figure.subplots(1, 2, sharey=True)
    for ax, estimates, label in zip(axes, (success, regret), ("success", f"cumulative regret ({unit})"), strict=True):
        _intervals(ax, rows, series, estimates, clip_on=False)
        ax.set_xlabel(label)
    axes[0].set_xlim(0, 1)
    axes[0].xaxis.set_major_formatter(PercentFormatter(1))
    axes[1].set_xlim(left=0)
    axes[1].xaxis.set_major_locator(ticks())
    _label_rows(axes[0], rows)
    legend(figure, axes[0], 1.0)
    return figure


def gain_plot(
    rows: Sequence[str],
    series: Sequence[str],
    gains: Mapping[tuple[str, str], Estimate],
    single: Mapping[tuple[str, str], Sequence[float]],
    baseline: str,
) -> Figure:
    """The scores of teachers with students: a dot with its interval per row and series, over faint marks.

    Args:
        rows: teachers from top to bottom.
        series: students in the order of their colours.
        gains: scores over all families, by (row, series); missing ones are blank.
        single: scores in each family, drawn as marks; those beyond the axis are drawn at its end.
        baseline: the teacher at 0.
    """
    figure = Figure(figsize=(WIDTH, max(0.3, 0.11 * len(series) + 0.06, tallest(rows)) * len(rows) + 1.1))
    ax = figure.subplots()
    ends = [end for gain in gains.values() for end in gain[:3] if not math.isnan(end)]
    least, most = min([-0.1, *ends]) - 0.03, max([1.0, *ends]) + 0.03
    marks = {pair: [min(max(share, least), most) for share in shares] for pair, shares in single.items()}
    line = {"linewidth": 2, "alpha": None}
    _intervals(ax, rows, series, gains, spacing=0.22, at_zero=True, marks=marks, line=line, markersize=5.5)
    ax.set_xlim(least, most)
    ax.xaxis.set_major_locator(ticks())
    ax.set_xlabel(f"score against {baseline}: above 0 the teacher is better")
    _label_rows(ax, rows)
    legend(figure, ax, 1.0)
    return figure


class Pane(NamedTuple):
    """One panel of `panel_plot`."""

    title: str
    unit: str
    """Unit of its axis."""
    dots: Mapping[tuple[str, str], Estimate]
    """By row and series; missing ones are blank."""


def panel_plot(panels: Sequence[Pane], rows: Sequence[str], series: Sequence[str], label: str) -> Figure:
    """A dot with its interval per row and series, and a line at 0; panels share rows and series, but not the axis.

    Args:
        panels: at least one.
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        label: of the axis; the unit of each panel is added.
    """
    columns = min(_BESIDE, len(panels))
    height = math.ceil(len(panels) / columns)
    pitch = max(0.22, 0.1 * len(series) + 0.04, tallest(rows))
    figure = Figure(figsize=(WIDTH, (pitch * len(rows) + 0.75) * height + 0.5))
    grid = figure.subplots(height, columns, sharey=True, squeeze=False).flatten()
    for ax, panel in zip(grid, panels, strict=False):
        _intervals(ax, rows, series, panel.dots, at_zero=True)
        ax.set_title(textwrap.fill(panel.title, 100 // columns), loc="left", color=SHADES["ink"].light)
        ax.set_xlabel(f"{label} ({panel.unit})")
        ax.xaxis.set_major_locator(ticks())
    for ax in grid[len(panels) :]:
        ax.set_axis_off()
    _label_rows(grid[0], rows)
    for ax in grid[:: len(grid) // height]:
        ax.tick_params(axis="y", labelcolor=SHADES["ink"].light)
    legend(figure, grid[0], 1.0)
    return figure


def curve_plot(panels: Mapping[str, Mapping[str, Band]], series: Sequence[str], unit: str) -> Figure:
    """Cumulative regret over turns: panels with a line and a band per series.

    Equal lines are drawn as one line in stripes of their colours, or in black if all lines of a panel are equal.

    Args:
        panels: bands by panel title, then by series; element t - 1 of a band is turn t.
        series: labels in the order of their colours and markers.
        unit: of regret.
    """
    columns = min(3, len(panels))
    height = math.ceil(len(panels) / columns)
    figure = Figure(figsize=(WIDTH, 2.3 * height + 0.8))
    axes = figure.subplots(height, columns, sharex=True, sharey=True, squeeze=False).flatten()
    styles = dict(zip(series, zip(cycle(SERIES), cycle(MARKERS), strict=False), strict=False))
    for ax, (title, bands) in zip(axes, panels.items(), strict=False):
        _curves(ax, bands, styles)
        ax.set_title(textwrap.fill(title, 100 // columns), loc="left", color=SHADES["ink"].light)
        ax.grid(axis="y")
        ax.margins(x=0)
    axes[0].xaxis.set_major_locator(ticks(integer=True))
    axes[0].yaxis.set_major_locator(ticks())
    axes[0].set_ylim(bottom=0)
    for ax in axes[len(panels) :]:
        ax.set_axis_off()
    for ax in axes[max(0, len(panels) - columns) : len(panels)]:
        ax.tick_params(labelbottom=True)
    for name, (color, marker) in styles.items():
        axes[0].plot([], [], color=color, marker=marker, label=named(name))
    figure.supxlabel("turn", size=9, color=SHADES["muted"].light)
    figure.supylabel(f"cumulative regret ({unit})", size=9, color=SHADES["muted"].light)
    legend(figure, axes[0], 2.2)
    return figure


def _curves(ax: Axes, bands: Mapping[str, Band], styles: Mapping[str, tuple[str, str]]) -> None:
    groups: list[list[str]] = []
    for name in bands:
        alike = (group for group in groups if np.allclose(bands[group[0]].mean, bands[name].mean))
        if (group := next(alike, None)) is not None:
            group.append(name)
        else:
            groups.append([name])
    for group in groups:
        mean, low, high = (np.concatenate([[0.0], curve]) for curve in bands[group[0]])
        turns = np.arange(len(mean))
        plain = len(group) == len(bands) > 1
        shade = SHADES["muted"].light if len(group) > 1 else styles[group[0]][0]
        ax.fill_between(turns, low, high, color=shade, alpha=0.15, linewidth=0)
        if plain:
            ax.plot(turns, mean, color=SHADES["ink"].light, clip_on=False, zorder=3)
            ax.text(0.03, 0.94, "all coincide", transform=ax.transAxes, va="top", color=shade)
            continue
        every = max(2, len(turns) // 3)
        for i, name in enumerate(group):
            color, marker = styles[name]
            stripes = (-i * _STRIPE, (_STRIPE, (len(group) - 1) * _STRIPE)) if len(group) > 1 else "solid"
            first = 1 + list(styles).index(name) * every // len(
                styles
            )  # so that markers of different lines do not overlap
            line = ax.plot(turns, mean, color=color, linestyle=stripes, clip_on=False, zorder=3)[0]
            line.set(marker=marker, markevery=(first, every))


def profile_plot(profiles: Mapping[str, tuple[Sequence[float], Band]]) -> Figure:
    """Performance profiles: a line and a band per label for the share of the runs above a score.

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
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.set_xlabel("score against the baseline")
    ax.set_ylabel("runs above it")
    ax.grid()
    legend(figure, ax, 2.2)
    return figure


def ticks(integer: bool = False) -> MaxNLocator:
    """Few ticks, at round numbers."""
    return MaxNLocator(6, steps=[1, 2, 5, 10], integer=integer)


def folded(label: str) -> str:
    """The label, wrapped if it is long."""
    return textwrap.fill(label, 30)


def tallest(rows: Sequence[str]) -> float:
    """Height of the tallest label in inches, so that labels do not overlap."""
    return 0.15 * max((folded(row).count("\n") + 1 for row in rows), default=1) + 0.04


def named(label: str) -> str:
    """The label in a form that Matplotlib shows; it leaves out labels that begin with an underscore."""
    label = textwrap.fill(label, 100)
    return f" {label}" if label.startswith("_") else label


def legend(figure: Figure, ax: Axes, handle: float, most: int = 125) -> int:
    """Add a legend above all axes, in as many columns as fit; returns the number of its rows.

    Args:
        figure: gets the legend.
        ax: has the series.
        handle: length of a line, in ems.
        most: characters that fit into a row.
    """
    handles, labels = ax.get_legend_handles_labels()
    columns = max(1, min(len(labels), int(most / (max(map(len, labels)) + 8))))
    figure.legend(handles, labels, loc="outside upper left", ncols=columns, handlelength=handle, columnspacing=1.8)
    return math.ceil(len(labels) / columns)


def make_narrow(figure: Figure) -> None:
    """Lay a figure of one panel out for a phone: the same letters on less width."""
    for ax in figure.axes:
        ax.set_xlabel(textwrap.fill(ax.get_xlabel(), 40))
        ax.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    (old,) = figure.legends
    old.remove()
    rows = legend(figure, figure.axes[0], old.handlelength, 45)
    figure.set_size_inches(_NARROW, figure.get_figheight() + 0.17 * rows)
