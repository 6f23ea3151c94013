"""What the programs of this folder share: seeds on all cores, declared effects and their verdict, tables and plots."""

import argparse
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.studies.analysis.statistics import Estimate, holm, mean_interval, p_words, paired_difference

FIRST_SEED = 70_000
"""Thresholds were chosen on smaller seeds."""
TENTH = 0.1
"""The smallest effect that counts, as a share of what it is compared with."""


class Effect(NamedTuple):
    """An effect that was declared before anything was played."""

    expects: str
    seen: np.ndarray
    """One value a seed."""
    least: np.ndarray
    """The smallest value that counts, for each seed; below 0 it is the greatest loss that does not count."""


def saving(expects: str, by: np.ndarray, beside: np.ndarray) -> Effect:
    """The effect that regret is smaller, by a tenth of the regret beside which it is put."""
    return Effect(expects, beside - by, TENTH * beside)


def parsed(doc: str | None, seeds: int) -> argparse.Namespace:
    """The arguments of a program: `--seeds`, which is `seeds` by default, and `--plot`."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=seeds, help=f"seeds; by default {seeds}")
    parser.add_argument("--plot", help="file to draw to")
    return parser.parse_args()


def played(measure: Callable[..., Sequence[float]], settings: Sequence[Any], seeds: int) -> dict[Any, np.ndarray]:
    """What `measure(*setting, seed)` gives, by setting: shape (seeds, numbers)."""
    tasks = [(*setting, FIRST_SEED + number) for setting in settings for number in range(seeds)]
    with ProcessPoolExecutor() as pool:
        found = np.array(list(pool.map(partial(_call, measure), tasks)))
    return dict(zip(settings, found.reshape(len(settings), seeds, -1), strict=True))


def _call(measure: Callable[..., Sequence[float]], arguments: tuple[Any, ...]) -> Sequence[float]:
    return measure(*arguments)


def cell(values: np.ndarray, digits: int = 2) -> str:
    """A mean with its 95 % interval; a star where none would cover."""
    estimate = mean_interval(values)
    return f"{estimate.mean:.{digits}f}*" if estimate.why else estimate.text(digits)


def print_table(*rows: Sequence[str]) -> None:
    """Print a table in Markdown; the first row has the heads."""
    heads, *others = rows
    for row in (heads, ["---"] * len(heads), *others):
        print("|", " | ".join(row), "|")
    print()


def verdicts_of(effects: Sequence[Effect], declared: int = 0) -> list[str]:
    """Print the test of each effect against the smallest that counts, and return the verdicts: yes, no or open.

    The tests are two-sided sign-flip tests over seeds, with Holm's correction for all effects that were declared, at
    least those that are given. An effect is found if it is significantly greater than the smallest that counts, not
    found if significantly smaller, else open.
    """
    tests = [paired_difference(each.seen, each.least) for each in effects]
    adjusted = holm([*(test.p for test in tests), *[1.0] * (declared - len(tests))])
    rows, verdicts = [], []
    for effect, test, p in zip(effects, tests, adjusted, strict=False):
        verdicts.append("open" if p >= 0.05 else "yes" if test.estimate.mean > 0 else "no")
        rows.append([effect.expects, f"{effect.least.mean():.2f}", cell(effect.seen), p_words(p), verdicts[-1]])
    print_table(["expected", "smallest that counts", "seen", "p after Holm", "verdict"], *rows)
    return verdicts


def together(verdicts: Sequence[str]) -> str:
    """The verdict over several effects."""
    return "no" if "no" in verdicts else "open" if "open" in verdicts else "yes"


def print_verdict(effects: Sequence[Effect]) -> None:
    """Print the test of each effect, see `verdicts_of`, and the verdict over all."""
    verdicts = verdicts_of(effects)
    found, seeds = verdicts.count("yes"), len(effects[0].seen)
    print(f"Verdict: {together(verdicts)} ({found} of {len(verdicts)} effects found, {seeds} seeds)")


def draw_line(axes: Any, places: Sequence[float], columns: np.ndarray, label: str) -> None:
    """Draw the means of columns, shape (seeds, places), with their intervals."""
    found = [mean_interval(column) for column in columns.T]
    axes.errorbar(places, [each.mean for each in found], _ends(found), label=label, capsize=2)


def draw_bars(axes: Any, groups: Sequence[str], series: Mapping[str, Sequence[np.ndarray]]) -> None:
    """Draw groups of bars with intervals: of each series a bar in each group."""
    places, width = np.arange(len(groups)), 0.8 / len(series)
    for number, (name, columns) in enumerate(series.items()):
        found = [mean_interval(column) for column in columns]
        shift = (number - (len(series) - 1) / 2) * width
        axes.bar(places + shift, [each.mean for each in found], width, yerr=_ends(found), label=name)
    axes.set_xticks(places, groups)


def _ends(found: Sequence[Estimate]) -> list[list[float]]:
    """The lengths of intervals below and above their means, as Matplotlib takes them."""
    return [[each.mean - each.low for each in found], [each.high - each.mean for each in found]]
