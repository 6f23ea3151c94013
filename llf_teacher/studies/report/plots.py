"""The plots of a report, by Matplotlib.

Series differ in lightness and markers, too, so that no plot depends on colour alone. Lines have labels at their ends;
at most six have a colour, the others are grey. Series of dots are split into plots of at most six. Every plot has a
form for phones: the same letters on less width, with panels below each other.
"""

import math
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.text import Annotation
from matplotlib.ticker import MaxNLocator, PercentFormatter

from llf_teacher.studies.analysis.statistics import Band, Estimate
from llf_teacher.theme import LENGTHS, SHADES

SERIES = [shade.light for name, shade in SHADES.items() if name.startswith("series")]
"""The colours of series."""
MARKERS = "osD^vP"
"""The markers of series, in the order of their colours."""
MOST = len(SERIES)
"""Greatest number of series in a plot."""
WIDTH = 10.0
"""Width of figures in inches; the page scales them."""
NARROW = 4.1
"""Width for a phone, where letters then have the size of those in a wide figure."""
_BODY = 10.5  # points: the size of the page's body in a figure of its width
_SMALL = round(_BODY * LENGTHS["small"])
_OTHERS: dict[str, Any] = {"color": SHADES["muted"].light, "alpha": 0.5, "linewidth": 1, "zorder": 1}
_LINE = 1.25  # height of a line of labels, in sizes of the font
_ASIDE = 14.0  # points from the end of a line to its label
STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": SHADES["muted"].light,
    "axes.labelcolor": SHADES["muted"].light,
    "axes.labelsize": _SMALL,
    "axes.spines.left": False,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": _BODY,
    "figure.constrained_layout.h_pad": 0.07,
    "figure.constrained_layout.use": True,
    "font.size": _SMALL,
    "grid.color": SHADES["rule"].light,
    "grid.linewidth": 0.7,
    "legend.borderpad": 0,
    "legend.fontsize": _SMALL,
    "legend.frameon": False,
    "legend.labelcolor": SHADES["ink"].light,
    "lines.dash_capstyle": "butt",
    "lines.linewidth": 1.5,
    "lines.markersize": 4.4,
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
    """Draw a dot with its interval per row and series, at most `MOST`, on alternating stripes.

    Args:
        ax: to draw on.
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        estimates: by (row, series); missing estimates are blank.
        spacing: greatest distance of two series, in rows.
        at_zero: whether there is a line at 0.
        marks: values by (row, series), drawn faintly behind the dots.
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
        dots.set_in_layout(False)  # without data their empty extent breaks the layout
    ax.grid(axis="x")


def _label_rows(ax: Axes, rows: Sequence[str], narrow: bool) -> None:
    """Name the rows, the first one at the top."""
    ax.set_ylim(len(rows) - 0.5, -0.5)
    ax.set_yticks(range(len(rows)), [folded(row, narrow) for row in rows], color=SHADES["ink"].light)


def _parts(
    series: Sequence[str], width: float, height: Callable[[int], float]
) -> tuple[Figure, list[tuple[FigureBase, Sequence[str]]]]:
    """A figure with a part for each `MOST` series, below each other.

    Args:
        series: all of them.
        width: of the figure in inches.
        height: of a part in inches, by the number of its series.
    """
    groups = [series[first : first + MOST] for first in range(0, len(series), MOST)] or [series]
    heights = [height(len(group)) for group in groups]
    figure = Figure(figsize=(width, sum(heights)))
    parts = figure.subfigures(len(groups), 1, squeeze=False, height_ratios=heights).flatten()
    return figure, list(zip(parts, groups, strict=True))


def dot_plot(
    rows: Sequence[str],
    series: Sequence[str],
    success: Mapping[tuple[str, str], Estimate],
    regret: Mapping[tuple[str, str], Estimate],
    unit: str,
    width: float = WIDTH,
) -> Figure:
    """Success and final cumulative regret, side by side or on a phone below each other: a dot per row and series.

    Args:
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        success: shares, 0 to 1, by (row, series); missing ones are blank.
        regret: cumulative regrets in `unit`, by (row, series).
        unit: of regret.
        width: of the figure in inches.
    """
    narrow = width < WIDTH

    def height(count: int) -> float:
        pitch = max(0.36, 0.1 * count + 0.04, tallest(rows, narrow))
        return (pitch * len(rows) + 0.6) * (2 if narrow else 1) + 0.4

    figure, parts = _parts(series, width, height)
    for part, group in parts:
        axes = part.subplots(2 if narrow else 1, 1 if narrow else 2, sharey=True, squeeze=False).flatten()
        for ax, estimates, label in zip(
            axes, (success, regret), ("success", f"cumulative regret ({unit})"), strict=True
        ):
            _intervals(ax, rows, group, estimates, clip_on=False)
            ax.set_xlabel(label)
        axes[0].set_xlim(0, 1)
        axes[0].xaxis.set_major_formatter(PercentFormatter(1))
        axes[0].xaxis.set_major_locator(ticks(narrow=narrow))
        axes[1].set_xlim(left=0)
        axes[1].xaxis.set_major_locator(ticks(narrow=narrow))
        _label_rows(axes[0], rows, narrow)
        axes[1].tick_params(axis="y", labelcolor=SHADES["ink"].light)
        legend(part, axes[0], narrow)
    return figure


def gain_plot(
    rows: Sequence[str],
    series: Sequence[str],
    gains: Mapping[tuple[str, str], Estimate],
    single: Mapping[tuple[str, str], Sequence[float]],
    baseline: str,
    width: float = WIDTH,
) -> Figure:
    """The scores of teachers with students: a dot with its interval per row and series, over faint marks.

    Args:
        rows: teachers from top to bottom.
        series: students in the order of their colours.
        gains: scores over all families, by (row, series); missing scores are blank.
        single: scores in each family, drawn as marks; marks beyond the axis are drawn at its end.
        baseline: what is at 0, such as the teacher of the rows that name none; empty: all name one.
        width: of the figure in inches.
    """
    narrow = width < WIDTH
    figure, parts = _parts(
        series,
        width,
        lambda count: max(0.3, 0.11 * count + 0.06, tallest(rows, narrow)) * len(rows) + 1.1 + 0.2 * narrow,
    )
    ends = [end for gain in gains.values() for end in gain[:3] if not math.isnan(end)]
    least, most = min([-0.1, *ends]) - 0.03, max([1.0, *ends]) + 0.03
    marks = {pair: [min(max(share, least), most) for share in shares] for pair, shares in single.items()}
    line = {"linewidth": 2, "alpha": None}
    for part, group in parts:
        ax = part.subplots()
        _intervals(ax, rows, group, gains, spacing=0.22, at_zero=True, marks=marks, line=line, markersize=5.5)
        ax.set_xlim(least, most)
        ax.xaxis.set_major_locator(ticks(narrow=narrow))
        label = f"score{f' against {baseline}' if baseline else ''}: above 0 the teacher is better"
        ax.set_xlabel(textwrap.fill(label, 40) if narrow else label)
        _label_rows(ax, rows, narrow)
        legend(part, ax, narrow)
    return figure


class Pane(NamedTuple):
    """One panel of `panel_plot`."""

    title: str
    unit: str
    """Unit of its axis."""
    dots: Mapping[tuple[str, str], Estimate]
    """By row and series; missing values are blank."""


def panel_plot(
    panels: Sequence[Pane], rows: Sequence[str], series: Sequence[str], label: str, width: float = WIDTH
) -> Figure:
    """A dot with its interval per row and series, and a line at 0; panels share rows and series, but not the axis.

    Args:
        panels: at least one.
        rows: labels from top to bottom.
        series: labels in the order of their colours.
        label: of the axis; the unit of each panel is added.
        width: of the figure in inches.
    """
    narrow = width < WIDTH
    columns = min(1 if narrow else 2, len(panels))
    lines = math.ceil(len(panels) / columns)

    def height(count: int) -> float:
        return (max(0.22, 0.1 * count + 0.04, tallest(rows, narrow)) * len(rows) + 0.75) * lines + 0.5

    figure, parts = _parts(series, width, height)
    for part, group in parts:
        grid = part.subplots(lines, columns, sharey=True, squeeze=False).flatten()
        for ax, panel in zip(grid, panels, strict=False):
            _intervals(ax, rows, group, panel.dots, at_zero=True)
            _title(ax, panel.title, columns, narrow)
            ax.set_xlabel(f"{label} ({panel.unit})")
            ax.xaxis.set_major_locator(ticks(narrow=narrow))
        for ax in grid[len(panels) :]:
            ax.set_axis_off()
        _label_rows(grid[0], rows, narrow)
        for ax in grid[::columns]:
            ax.tick_params(axis="y", labelcolor=SHADES["ink"].light)
        legend(part, grid[0], narrow)
    return figure


def curve_plot(
    panels: Mapping[str, Mapping[str, Band]], series: Sequence[str], unit: str, width: float = WIDTH
) -> Figure:
    """Cumulative regret over turns: panels with a line and a band per series, whose name stands at its end.

    Equal lines are drawn as one, with all their names. Lines that are not among the series are grey, without a name.

    Args:
        panels: bands by panel title, then by series; element t - 1 of a band is turn t.
        series: at most `MOST` labels in the order of their colours and markers.
        unit: of regret.
        width: of the figure in inches.
    """
    narrow = width < WIDTH
    columns = min(1 if narrow else 2, len(panels))
    height = math.ceil(len(panels) / columns)
    figure = Figure(figsize=(width, 2.5 * height + 0.3))
    axes = figure.subplots(height, columns, sharex=True, sharey=True, squeeze=False).flatten()
    styles = dict(zip(series, zip(SERIES, MARKERS, strict=True), strict=False))
    labels = []
    for ax, (title, bands) in zip(axes, panels.items(), strict=False):
        labels += _curves(ax, bands, styles)
        _title(ax, title, columns, narrow)
        ax.grid(axis="y")
        ax.margins(x=0)
    axes[0].xaxis.set_major_locator(ticks(integer=True, narrow=narrow))
    axes[0].yaxis.set_major_locator(ticks())
    if min(ax.dataLim.y0 for ax in axes[: len(panels)]) >= 0:  # negated rewards in place of regret lie below
        axes[0].set_ylim(bottom=0)
    for ax in axes[len(panels) :]:
        ax.set_axis_off()
    for ax in axes[max(0, len(panels) - columns) : len(panels)]:
        ax.tick_params(labelbottom=True)
    figure.supxlabel("turn", size=_SMALL, color=SHADES["muted"].light)
    figure.supylabel(f"cumulative regret ({unit})", size=_SMALL, color=SHADES["muted"].light)
    separate(figure, labels)
    return figure


def _curves(ax: Axes, bands: Mapping[str, Band], styles: Mapping[str, tuple[str, str]]) -> list[Annotation]:
    """Draw the lines of a panel; returns their labels."""
    groups: list[list[str]] = []
    for name in bands:
        if name not in styles:
            ax.plot(np.concatenate([[0.0], bands[name].mean]), **_OTHERS)
            continue
        alike = (group for group in groups if np.allclose(bands[group[0]].mean, bands[name].mean))
        if (group := next(alike, None)) is not None:
            group.append(name)
        else:
            groups.append([name])
    labels = []
    for group in groups:
        mean, low, high = (np.concatenate([[0.0], curve]) for curve in bands[group[0]])
        turns = np.arange(len(mean))
        color, marker = styles[group[0]]
        ax.fill_between(turns, low, high, color=color, alpha=0.15, linewidth=0)
        every = max(2, len(turns) // 3)
        first = 1 + list(styles).index(group[0]) * every // len(styles)  # so that markers of lines do not overlap
        ax.plot(turns, mean, color=color, marker=marker, markevery=(first, every), clip_on=False, zorder=3)
        whole = len(bands) > 1 and all(np.allclose(mean[1:], each.mean) for each in bands.values())
        label = "all teachers alike" if whole else ", ".join(group)
        labels.append(name_end(ax, label, (turns[-1], mean[-1]), color))
    return labels


def name_end(ax: Axes, text: str, end: tuple[float, float], color: str) -> Annotation:
    """The name of a line beside its end, joined to it by a thin line."""
    return ax.annotate(
        named(text, 22),
        end,
        (_ASIDE, 0),
        textcoords="offset points",
        va="center",
        color=SHADES["ink"].light,
        annotation_clip=False,
        arrowprops={"arrowstyle": "-", "color": color, "linewidth": 1, "relpos": (0, 0.5), "shrinkA": 1, "shrinkB": 0},
    )


def separate(figure: Figure, labels: Sequence[Annotation]) -> None:
    """Move labels up or down so that none of a panel lies on another; of equal ends the first label is uppermost."""
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine("none")  # the layout is done; do not repeat it
    for ax in figure.axes:
        mine = sorted((each for each in reversed(labels) if each.axes is ax), key=lambda each: each.xy[1])
        room = ax.bbox.height / figure.dpi * 72
        heights = [_LINE * _SMALL * (each.get_text().count("\n") + 1) for each in mine]
        wanted = [(ax.transData.transform(each.xy)[1] - ax.bbox.y0) / figure.dpi * 72 for each in mine]
        for label, place, at in zip(mine, spread(wanted, heights, room), wanted, strict=True):
            label.set_position((_ASIDE, place - at))


def spread(wanted: Sequence[float], heights: Sequence[float], room: float) -> list[float]:
    """Places for boxes without overlap, near the wanted places and in their order, between 0 and `room` if they fit.

    Args:
        wanted: the middles of boxes, ascending.
        heights: of the boxes, in the same unit.
        room: the greatest place of an upper edge.
    """
    places: list[float] = []
    for want, height in zip(wanted, heights, strict=True):
        floor = places[-1] + heights[len(places) - 1] / 2 if places else 0.0
        places.append(max(want, floor + height / 2))
    ceiling = max(room, sum(heights))
    for i in reversed(range(len(places))):
        places[i] = min(places[i], ceiling - heights[i] / 2)
        ceiling = places[i] - heights[i] / 2
    return places


def profile_plot(profiles: Mapping[str, tuple[Sequence[float], Band]], width: float = WIDTH) -> Figure:
    """Performance profiles: a line and a band per label, which stands at its end, for the share of seeds above a score.

    Args:
        profiles: scores and shares, 0 to 1, by label; the first `MOST` have a colour and a name, the others are grey.
        width: of the figure in inches.
    """
    narrow = width < WIDTH
    figure = Figure(figsize=(width, 3.4))
    ax = figure.subplots()
    names = list(profiles)[:MOST]
    for scores, band in list(profiles.values())[MOST:]:
        ax.plot(scores, band.mean, **_OTHERS)
    labels = []
    for name, color, marker in zip(names, SERIES, MARKERS, strict=False):
        scores, band = profiles[name]
        ax.fill_between(scores, band.low, band.high, color=color, alpha=0.15, linewidth=0)
        ax.plot(scores, band.mean, color=color, marker=marker, markevery=5, zorder=3)
        labels.append(name_end(ax, name, (scores[-1], band.mean[-1]), color))
    ax.axvline(0, color=SHADES["ink"].light, linewidth=1)
    ax.set_ylim(0, 1)
    ax.margins(x=0)
    ax.xaxis.set_major_locator(ticks(narrow=narrow))
    ax.yaxis.set_major_formatter(PercentFormatter(1))
    ax.set_xlabel("score against the baseline")
    ax.set_ylabel("seeds above it")
    ax.grid()
    separate(figure, labels)
    return figure


def ticks(integer: bool = False, narrow: bool = False) -> MaxNLocator:
    """Few ticks, at round numbers."""
    return MaxNLocator(4 if narrow else 6, steps=[1, 2, 5, 10], integer=integer)


def _title(ax: Axes, title: str, columns: int, narrow: bool) -> None:
    ax.set_title(textwrap.fill(title, 40 if narrow else 100 // columns), loc="left", color=SHADES["ink"].light)


class _Folding(textwrap.TextWrapper):
    """Breaks lines after a plus sign, too, which joins kinds of feedback."""

    def _split(self, text: str) -> list[str]:
        return [part for chunk in super()._split(text) for part in re.split(r"(?<=\+)", chunk) if part]


def folded(label: str, narrow: bool = False) -> str:
    """The label, wrapped if it is long."""
    return _Folding(20 if narrow else 30).fill(label)


def tallest(rows: Sequence[str], narrow: bool = False) -> float:
    """Height of the tallest label in inches, so that labels do not overlap."""
    return 0.15 * max((folded(row, narrow).count("\n") + 1 for row in rows), default=1) + 0.04


def named(label: str, most: int = 100) -> str:
    """The label in a form that Matplotlib shows, since it omits labels that begin with an underscore."""
    label = textwrap.fill(label, most)
    return f" {label}" if label.startswith("_") else label


def legend(figure: FigureBase, ax: Axes, narrow: bool) -> None:
    """Add a legend above all axes, in as many columns as fit.

    Args:
        figure: gets the legend.
        ax: has the series.
        narrow: whether the figure is for a phone.
    """
    handles, labels = ax.get_legend_handles_labels()
    most = 45 if narrow else 125  # characters in a row
    columns = max(1, min(len(labels), int(most / (max(map(len, labels)) + 8))))
    figure.legend(handles, labels, loc="outside upper left", ncols=columns, handlelength=1.0, columnspacing=1.8)
