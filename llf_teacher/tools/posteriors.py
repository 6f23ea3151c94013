"""Whether posteriors are calibrated, and what they cost."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from time import process_time
from typing import NamedTuple

import numpy as np
from rich.table import Table

from llf_teacher.registry import Entry
from worlds.posteriors import testing as kit

__all__ = ["Ranked", "measure", "plot", "table"]

_EPISODES = 20
_BAND = 0.99


class Ranked(NamedTuple):
    """The posterior of one environment."""

    id: str
    calibration: dict[str, kit.Calibration]
    """By the name of the quantity."""
    reset: float
    """Mean time of a reset of the world, in microseconds of the processor."""
    draw: float
    """Mean time of drawing a world, likewise."""


def measure(entry: Entry, histories: int, seed: int) -> Ranked:
    """Rank true worlds among drawn ones by simulation-based calibration, and take the time of draws."""
    rng = np.random.default_rng(seed)
    make_posterior = entry.family.make_posterior
    make = partial(entry.family.make_world, **{**entry.options, **entry.family.posterior_needs})
    ranks = kit.rank(make, make_posterior, rng, histories)
    world = make()
    posterior = make_posterior(world)
    past = [kit.history(world, rng) for _ in range(_EPISODES)]
    draw = _time([partial(posterior.take, turns, rng, kit.DRAWS) for turns in past]) / kit.DRAWS
    reset = _time([partial(world.reset, seed=int(number)) for number in rng.integers(2**31, size=10 * _EPISODES)])
    return Ranked(entry.id, {name: kit.uniformity(each) for name, each in ranks.items()}, reset, draw)


def _time(calls: Sequence[Callable[[], object]]) -> float:
    """Mean processor time of a call in microseconds."""
    start = process_time()
    for call in calls:
        call()
    return (process_time() - start) / len(calls) * 1e6


def table(found: Iterable[Ranked]) -> Table:
    """A row for each environment."""
    shown = Table(box=None, padding=(0, 2, 0, 0))
    for column in ("environment", "least p", "of", "a reset, µs", "a draw, µs", "resets in a draw"):
        shown.add_column(column, justify="left" if column in ("environment", "of") else "right")
    for each in found:
        name, least = min(each.calibration.items(), key=lambda item: item[1].p)
        times = f"{each.reset:,.0f}", f"{each.draw:,.0f}", f"{each.draw / each.reset:.2f}"
        shown.add_row(each.id, f"{least.p:.3g}", name, *times)
    return shown


def plot(found: Sequence[Ranked], file: str) -> None:
    """Draw the ranks: a panel for each family, with a line for each quantity of each of its environments.

    A line is the empirical distribution of the ranks less that of equally likely ones. If these are the right one, it
    stays in the band with probability 99 % (Dvoretzky, Kiefer & Wolfowitz 1956, with Massart's constant).
    """
    import matplotlib.style
    from matplotlib.figure import Figure

    from llf_teacher.registry import entry
    from llf_teacher.studies.report.plots import SERIES, STYLE
    from llf_teacher.theme import SHADES

    families: dict[str, list[kit.Calibration]] = {}
    for each in found:
        families.setdefault(entry(each.id).family.name, []).extend(each.calibration.values())
    with matplotlib.style.context([STYLE]):
        figure = Figure(figsize=(3 * len(families), 2.6))
        panels = figure.subplots(1, len(families), sharey=True, squeeze=False)[0]
        for axes, (name, lines) in zip(panels, families.items(), strict=True):
            histories, ranks = int(lines[0].counts.sum()), len(lines[0].counts)
            band = math.sqrt(math.log(2 / (1 - _BAND)) / (2 * histories))
            axes.axhspan(-band, band, color=SHADES["rule"].light, linewidth=0)
            for _, counts in lines:
                even = np.arange(1, ranks + 1) / ranks
                axes.plot(range(ranks), np.cumsum(counts) / histories - even, color=SERIES[0], linewidth=0.8)
            axes.set_title(f"{name}: {len(lines)} quantities, {histories:,} histories", fontsize=8)
            axes.set_xlabel("rank of the true world", fontsize=8)
        panels[0].set_ylim(-1.3 * band, 1.3 * band)
        panels[0].set_ylabel("share of ranks, less even", fontsize=8)
        figure.savefig(file)
