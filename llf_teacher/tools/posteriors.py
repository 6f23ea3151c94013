"""Whether posteriors are calibrated, and what they cost."""

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
    """Draw the ranks of each quantity, with the 99 % interval of a number of ranks if all are equally likely."""
    import matplotlib.style
    from matplotlib.figure import Figure
    from scipy.stats import binom

    from llf_teacher.studies.report.plots import SERIES, STYLE
    from llf_teacher.theme import SHADES

    panels = [(each.id, name, ranks) for each in found for name, ranks in each.calibration.items()]
    columns = 4
    rows = -(-len(panels) // columns)
    with matplotlib.style.context([STYLE]):
        figure = Figure(figsize=(3 * columns, 1.9 * rows))
        for place, (id, name, (p, counts)) in enumerate(panels, 1):
            axes = figure.add_subplot(rows, columns, place)
            low, high = binom.interval(_BAND, counts.sum(), 1 / len(counts))
            axes.axhspan(low, high, color=SHADES["rule"].light, linewidth=0)
            axes.bar(range(len(counts)), counts, color=SERIES[0], width=0.8)
            axes.set_title(f"{id.removeprefix('llf-')}\n{name}, p = {p:.2g}", fontsize=7)
            axes.set_xlabel("rank of the true world", fontsize=8)
        figure.savefig(file)
