"""How often the statistics of studies are right: error rates, power, and coverage of intervals, as tables.

Studies without an effect are made of episodes that were played: each world was played ten times with the same silent
teacher, by students that differ in their draws alone, and these ten are dealt at random to the teachers and students of
a study. Whatever such a study finds is an error. With a shift of the baseline's regrets the same studies have an effect
of known size. Intervals are tried on draws from distributions whose means are known.
"""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from llf_teacher.registry import PREFIX
from llf_teacher.studies.analysis.contrasts import Test
from llf_teacher.studies.analysis.estimators import interquartile_mean, probability_of_improvement
from llf_teacher.studies.analysis.outcomes import Endings, Group, Numbers, Outcomes
from llf_teacher.studies.analysis.primary import scores
from llf_teacher.studies.analysis.resampling import sign_flips
from llf_teacher.studies.analysis.sequential import ALPHA
from llf_teacher.studies.analysis.statistics import (
    LEVEL,
    RESAMPLES,
    holm,
    mean_band,
    rate_differences,
    rate_interval,
)
from llf_teacher.studies.definition.design import SPENDING, InterimAnalyses
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.runner import RunOptions, play_missing
from llf_teacher.studies.store import Store
from llf_teacher.tools.markdown import table
from pz_envs.family import all_families

TEACHERS, STUDENTS, BASELINE = ("oracle", "hinter", "mix", "placebo"), ("text_only", "obedient"), "silent"
"""The names of arms that are alike: eight comparisons with the baseline."""
SEEDS, AT = 20, (8, 14, 20)
"""Seeds of a study, and of its interim analyses."""
FAMILIES = (1, 2, 4, 8)
EFFECT = 0.8
"""Standardized difference of the positive control: a mean in standard deviations of paired differences."""
SIZES = (5, 10, 20, 40, 80)
_ARMS = (len(TEACHERS) + 1) * len(STUDENTS)
_TURNS = 10
_COLUMNS = 400  # columns that are tested at once, which bounds memory

Pool = Mapping[str, Numbers]
"""By family the regrets of the arms that are dealt, shape (worlds, arms)."""
Step = Callable[[], None]
"""Called after each study or draw."""


class Extent(NamedTuple):
    """How much a calibration draws."""

    studies: int
    """Studies per row of the tables of error rates and power."""
    draws: int
    """Draws per cell of the tables of coverage."""
    seed: int
    """Seed of all that is drawn here."""

    def rng(self, *key: int) -> np.random.Generator:
        """A generator of its own for each table and row."""
        return np.random.default_rng([self.seed, *key])


def pool_study(worlds: int) -> Study:
    """The study whose episodes are dealt: the first environment of each installed family."""
    families = [family for family in all_families() if not family.missing()]
    return Study(
        ids=[PREFIX + family.showcase[0] for family in families],
        teachers=[BASELINE],
        students=["text_only"],
        samples=_ARMS,
        seeds=worlds,
        max_turns=_TURNS,
    )


def read_pool(path: Path, worlds: int, progress: Callable[[int, int], None] | None = None) -> Pool:
    """The pool of a store, which gets the episodes that it lacks."""
    study = pool_study(worlds)
    with Store(path) as store:
        play_missing(study, store, 1, progress, options=RunOptions("here"))
        wanted = {spec.key for spec in study.episodes()}
        found: dict[str, Numbers] = {}
        for row in store.rows():
            if row["key"] in wanted:
                found.setdefault(row["family"], np.zeros((worlds, _ARMS)))[row["seed"], row["sample"]] = row["regret"]
    return found


def deal(pool: Pool, families: Sequence[str], rng: np.random.Generator, shift: Mapping[str, float]) -> Outcomes:
    """The outcomes of a study whose arms are alike, but for a shift of the baseline's regrets.

    Args:
        pool: what is dealt.
        families: those of the study.
        rng: draws the worlds, which are the same for all families, and deals.
        shift: by family, added to the baseline's regrets.
    """
    worlds = rng.choice(len(next(iter(pool.values()))), SEEDS, replace=False)
    seeds, nothing = np.arange(SEEDS), np.zeros(SEEDS)
    found: Outcomes = {}
    for family in families:
        regrets = rng.permuted(pool[family][worlds], axis=1)
        cells = {}
        for (teacher, student), regret in zip(product((*TEACHERS, BASELINE), STUDENTS), regrets.T, strict=True):
            more = shift[family] if teacher == BASELINE else 0.0
            cells[teacher, student] = Endings(seeds, regret + more, nothing, np.full((SEEDS, 1), np.inf))
        found[Group(family, "b", "a", _TURNS, "", "", 0, "", "", "", (family,))] = cells
    return found


def tests() -> dict[str, Test]:
    """The designs: one test, and interim analyses by each spending function."""
    waves = tuple(frozenset(range(seeds)) for seeds in AT)
    designs = {spending: InterimAnalyses(AT, spending) for spending in SPENDING}
    looks = {spending: Test(waves[-1], len(AT), waves[:-1], design) for spending, design in designs.items()}
    return {"one test": Test(waves[-1]), **looks}


class Tried(NamedTuple):
    """The comparisons of studies, tested at each analysis as if it were the only one."""

    primary: Numbers
    """p-values, shape (studies, comparisons, analyses)."""
    secondary: Numbers
    """Those of the families' tables, of the same shape."""
    score: Numbers
    """Mean scores of the primary comparisons over all seeds, shape (studies, comparisons)."""


def tried(pool: Pool, extent: Extent, families: int, effect: float, step: Step) -> Tried:
    """Deal and test studies; all of them together, which is fast."""
    rng = extent.rng(1 if not effect else 2, families)
    scored: list[list[Numbers]] = [[] for _ in AT]
    differing: list[list[Numbers]] = [[] for _ in AT]
    for _ in range(extent.studies):
        chosen = [str(name) for name in rng.choice(list(pool), min(families, len(pool)), replace=False)]
        outcomes = deal(pool, chosen, rng, _shift(pool, chosen, effect))
        for teacher, student in product(TEACHERS, STUDENTS):
            both = [(cells[teacher, student], cells[BASELINE, student]) for cells in outcomes.values()]
            for place, seeds in enumerate(AT):
                scored[place].append(scores(both, frozenset(range(seeds))))
                differing[place] += [own.regret[:seeds] - other.regret[:seeds] for own, other in both]
        step()
    shape = extent.studies, -1
    return Tried(
        np.stack([_p_values(each).reshape(shape) for each in scored], axis=-1),
        np.stack([_p_values(each).reshape(shape) for each in differing], axis=-1),
        np.array([each.mean() for each in scored[-1]]).reshape(shape),
    )


def _p_values(columns: Sequence[Numbers]) -> Numbers:
    parts = [np.column_stack(columns[i : i + _COLUMNS]) for i in range(0, len(columns), _COLUMNS)]
    return np.concatenate([sign_flips(part, RESAMPLES) for part in parts])


def adjusted(p_values: Numbers, test: Test) -> list[float]:
    """p-values of comparisons, shape (comparisons, analyses), adjusted as in a report."""
    if test.design is None:
        return holm([float(p) for p in p_values[:, -1]])
    return holm([min(test.adjusted(float(p), number) for number, p in enumerate(row, 1)) for row in p_values])


def errors(pool: Pool, extent: Extent, step: Step) -> str:
    """The share of studies without an effect that find one, among primary and among secondary comparisons."""
    designs = tests()
    rows: dict[tuple[str, int], tuple[str, ...]] = {}
    for count in FAMILIES:
        found = tried(pool, extent, count, 0.0, step)
        for name, test in designs.items():
            shares = (
                _rate(sum(min(adjusted(each, test)) <= ALPHA for each in table_), extent.studies)
                for table_ in found[:2]
            )
            rows[name, count] = name.replace("_", " "), f"{count}", *itertools.chain(*shares)
    ordered = [rows[key] for key in product(designs, FAMILIES)]
    return table(("design", "families", "primary, %", "at most, %", "secondary, %", "at most, %"), ordered)


def powers(pool: Pool, extent: Extent, step: Step) -> str:
    """The share of comparisons with a standardized difference of `EFFECT` that are found."""
    designs = tests()
    rows: dict[tuple[str, int], tuple[str, ...]] = {}
    for count in FAMILIES:
        found = tried(pool, extent, count, EFFECT, step)
        for name, test in designs.items():
            single = sum(
                adjusted(p[:1], test)[0] <= ALPHA and mean[0] > 0
                for p, mean in zip(found.primary, found.score, strict=True)
            )
            every = sum(
                p <= ALPHA and mean > 0
                for table_, means in zip(found.primary, found.score, strict=True)
                for p, mean in zip(adjusted(table_, test), means, strict=True)
            )
            low = stats.binomtest(single, extent.studies).proportion_ci(LEVEL).low
            shares = single / extent.studies, low, every / found.score.size
            rows[name, count] = name.replace("_", " "), f"{count}", *(f"{100 * each:.1f}" for each in shares)
    ordered = [rows[key] for key in product(designs, FAMILIES)]
    return table(("design", "families", "of one, %", "at least, %", "of each of eight, %"), ordered)


def _shift(pool: Pool, families: Sequence[str], effect: float) -> dict[str, float]:
    """What the baseline's regrets must be greater so that the score's mean is `effect` standard deviations."""
    means = {family: float(pool[family].mean()) for family in families}
    variances = [pool[f].var(axis=1, ddof=1).mean() / (2 * means[f] ** 2) for f in families]  # of an arm less another
    spread = float(np.sqrt(np.mean(variances) / len(families)))
    return {family: effect * spread * 2 * mean for family, mean in means.items()}


def _rate(count: int, of: int) -> tuple[str, str]:
    """A share and the upper end of its 95 % interval, in %."""
    return f"{100 * count / of:.1f}", f"{100 * stats.binomtest(count, of).proportion_ci(LEVEL).high:.1f}"


Draws = Callable[[np.random.Generator, tuple[int, int]], Numbers]


def _zeros(share: float) -> Draws:
    return lambda rng, size: np.where(rng.random(size) < share, 0.0, rng.exponential(size=size))


def _sparse(rng: np.random.Generator, size: tuple[int, int]) -> Numbers:
    return np.asarray(_zeros(0.5)(rng, size) * rng.choice((-1.0, 1.0), size))


SHAPES: dict[str, tuple[Draws, float]] = {
    "normal": (lambda rng, size: rng.normal(size=size), 0.0),
    "normal, mean 5": (lambda rng, size: rng.normal(5, 1, size), 5.0),
    "exponential": (lambda rng, size: rng.exponential(size=size), 1.0),
    "half zeros": (_zeros(0.5), 0.5),
    "80 % zeros": (_zeros(0.8), 0.2),
    "lognormal": (lambda rng, size: rng.lognormal(size=size), float(np.exp(0.5))),
    "gamma, skewness 1": (lambda rng, size: rng.gamma(4, size=size), 4.0),
    "difference of two exponential": (lambda rng, size: rng.exponential(size=size) - rng.exponential(size=size), 0.0),
    "half zeros, both signs": (_sparse, 0.0),
    "exponential less its mean": (lambda rng, size: rng.exponential(size=size) - 1, 0.0),
    "lognormal less its mean": (lambda rng, size: rng.lognormal(size=size) - float(np.exp(0.5)), 0.0),
}
"""Distributions by name, with their means: zeros are of a mixture with the exponential distribution."""


def coverage(extent: Extent, step: Step) -> str:
    """Coverage of Student's t, and of what a report shows: how often an interval, and its coverage."""
    rows = []
    for number, (name, (draw, mean)) in enumerate(SHAPES.items()):
        for n in SIZES:
            values = draw(extent.rng(3, number, n), (n, extent.draws))
            spread = stats.sem(values, axis=0)
            reach = stats.t.isf((1 - LEVEL) / 2, n - 1) * spread
            plain = np.abs(values.mean(axis=0) - mean) <= reach
            band = mean_band(values)
            shown = ~np.isnan(band.low)
            covers = (band.low <= mean) & (mean <= band.high)
            rows.append(
                (
                    *(name, f"{n}", f"{plain.mean():.2f}", f"{100 * shown.mean():.0f}"),
                    f"{covers[shown].mean():.2f}" if shown.mean() >= 0.01 else "",
                    f"{100 * (shown & ~covers).mean():.1f}",
                )
            )
            step()
    head = ("shape", "n", "Student's t covers", "interval shown, %", "it covers", "shown and wrong, %")
    return table(head, rows)


RATES = (0.02, 0.1, 0.3, 0.5)
PAIRED = ((0.05, 0.05), (0.3, 0.1), (0.6, 0.1))
"""Shares of pairs of which only the first succeeds, and only the second."""


def binary_coverage(extent: Extent, step: Step) -> str:
    """Coverage of the exact intervals of rates, and of differences of paired rates."""
    rows = []
    for number, rate in enumerate(RATES):
        cells = []
        for n in SIZES:
            counts = extent.rng(4, number, n).binomial(n, rate, extent.draws)
            by_count = {int(count): rate_interval(int(count), n) for count in np.unique(counts)}
            cells.append(np.mean([by_count[count].low <= rate <= by_count[count].high for count in counts.tolist()]))
            step()
        rows.append((f"{rate:g}", *(f"{cell:.2f}" for cell in cells)))
    for number, (gained, lost) in enumerate(PAIRED):
        cells = []
        for n in SIZES:
            drawn = extent.rng(5, number, n).choice(
                (1.0, -1.0, 0.0), (n, extent.draws), p=(gained, lost, 1 - gained - lost)
            )
            band = rate_differences(drawn == 1, drawn == -1)
            cells.append(np.mean((band.low <= gained - lost) & (gained - lost <= band.high)))
            step()
        rows.append((f"{gained:g} less {lost:g}, paired", *(f"{cell:.2f}" for cell in cells)))
    return table(("rate", *(f"n = {n}" for n in SIZES)), rows)


RUNS, TASKS = (5, 10, 20), (1, 4)
_FEWER = 10  # one draw for so many of the other tables: each is a bootstrap


def bootstrap_coverage(extent: Extent, step: Step) -> str:
    """Coverage of the bootstrap intervals of estimators over many tasks."""
    rows = []
    ranked = np.sort(np.random.default_rng(extent.seed).exponential(size=1_000_000))
    centres = {"normal": 0.0, "exponential": float(ranked[250_000:750_000].mean())}
    for (name, centre), tasks, runs in product(centres.items(), TASKS, RUNS):
        rng, draw = extent.rng(6, tasks, runs), SHAPES[name][0]
        counts = np.zeros(2)
        number = max(1, extent.draws // _FEWER)
        for _ in range(number):
            first, second = (list(draw(rng, (tasks, runs))) for _ in range(2))
            middle, better = interquartile_mean(first), probability_of_improvement(first, second)
            counts += middle.low <= centre <= middle.high, better.low <= 0.5 <= better.high
            step()
        cells = counts / number if not np.isnan(middle.low) else None
        shown = [f"{cell:.2f}" for cell in cells] if cells is not None else ["none", "none"]
        rows.append((name, f"{tasks}", f"{runs}", *shown))
    return table(("runs are", "tasks", "runs each", "interquartile mean", "probability of improvement"), rows)


def steps(extent: Extent) -> dict[str, int]:
    """The number of steps of each table."""
    many = extent.studies * len(FAMILIES)
    return {
        "errors": many,
        "powers": many,
        "coverage": len(SHAPES) * len(SIZES),
        "binary": (len(RATES) + len(PAIRED)) * len(SIZES),
        "bootstrap": 2 * len(TASKS) * len(RUNS) * max(1, extent.draws // _FEWER),
    }


def tables(extent: Extent, names: Sequence[str], pool: Pool, step: Callable[[str], Step]) -> Iterator[tuple[str, str]]:
    """Each table with its name, one by one.

    Args:
        extent: how much is drawn.
        names: some of those of `steps`.
        pool: the episodes for error rates and power.
        step: gives what is called after each step of a table.
    """
    plain: dict[str, Any] = {"coverage": coverage, "binary": binary_coverage, "bootstrap": bootstrap_coverage}
    for name in names:
        if name in plain:
            yield name, plain[name](extent, step(name))
        else:
            yield name, {"errors": errors, "powers": powers}[name](pool, extent, step(name))
