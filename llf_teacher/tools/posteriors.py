"""Whether posteriors are calibrated, and what they cost."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from rich.table import Table

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import Entry
from teachers.atoms import Moment
from teachers.belief import Belief
from worlds.posteriors import Draw
from worlds.posteriors import testing as kit

__all__ = ["Ranked", "TurnTimes", "costs", "measure", "plot", "table", "table_of_costs"]

_EPISODES = 20
_BAND = 0.99
_TURNS = 40
_LONGEST = 20.0  # seconds after which no more turns are measured


class TurnTimes(NamedTuple):
    """What a turn costs that uses posterior worlds, as mean times of the processor in milliseconds."""

    id: str
    worlds: int
    refreshed: float | None
    """What the student `reasoner` takes to draw worlds; None if it cannot play there."""
    weighed: float | None
    """What it takes to weigh these by the claims, and its actions in them."""
    informative: float
    """A turn of a lesson whose teacher is `informative`."""
    oracle: float
    """The same turn with the teacher `oracle`."""


class _Timed(Belief):
    """Takes the time of drawing."""

    drawing = 0.0

    def _next(self) -> Draw[Any]:
        start = process_time()
        found = super()._next()
        self.drawing += process_time() - start
        return found


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


def costs(entry: Entry, seed: int, worlds: int) -> TurnTimes:
    """Take the time of turns with random actions of the student."""
    informative, oracle = (_turn(entry, seed, teacher) for teacher in (f"informative(worlds={worlds})", "oracle"))
    return TurnTimes(entry.id, worlds, *_reasoning(entry, seed, worlds), informative, oracle)


def _lessons(entry: Entry, seed: int, teacher: str) -> Iterator[tuple[StudentEnv, float]]:
    """Turns of lessons, each with its time in seconds; the time between them is counted, too."""
    env = StudentEnv(entry.id, teacher=teacher, **entry.family.posterior_needs)
    rng = np.random.default_rng(seed)
    begun, turns = process_time(), 0
    while True:
        env.reset(seed=int(rng.integers(2**31)))
        over = False
        while not over:
            if turns == _TURNS or process_time() - begun > _LONGEST:
                return
            action = env.session.world.sample_action(rng)
            start = process_time()
            _, _, terminated, truncated, _ = env.step(action)
            over = terminated or truncated
            turns += 1
            yield env, process_time() - start


def _turn(entry: Entry, seed: int, teacher: str) -> float:
    """Mean time of a turn of a lesson in milliseconds."""
    return float(np.mean([seconds for _, seconds in _lessons(entry, seed, teacher)])) * 1e3


def _reasoning(entry: Entry, seed: int, worlds: int) -> tuple[float | None, float | None]:
    """Mean times in which a belief draws worlds, and weighs them, in milliseconds."""
    oracle: Any = entry.family.oracle_class()
    if "values" not in oracle.abilities():
        return None, None
    belief, took = None, []
    for env, _ in _lessons(entry, seed, "oracle"):
        moment = env.session.moment
        if belief is None or moment.turn == 1:
            grounds = entry.family.make_grounds(env.session.world)
            belief = _Timed(grounds, np.random.default_rng(seed), worlds)
            if moment.before is not None:
                belief.see(Moment.opening(moment.before))
        belief.drawing, start = 0.0, process_time()
        belief.see(moment)
        belief.learn(env.session.atoms)
        belief.regrets()
        took.append((belief.drawing, process_time() - start - belief.drawing))
    refreshed, weighed = np.mean(took, axis=0) * 1e3
    return float(refreshed), float(weighed)


def table_of_costs(found: Iterable[TurnTimes]) -> Table:
    """A row for each environment."""
    shown = Table(box=None, padding=(0, 2, 0, 0))
    columns = ("worlds", "reasoner draws, ms", "weighs, ms", "informative's turn, ms", "oracle's turn, ms")
    for column in ("environment", *columns):
        shown.add_column(column, justify="left" if column == "environment" else "right")
    for id, worlds, *times in found:
        shown.add_row(id, f"{worlds}", *("" if time is None else f"{time:,.2f}" for time in times))
    return shown


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
