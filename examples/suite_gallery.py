"""The suite's cards of all scripted students beside each other, and whether other worlds order the students alike.

    python examples/suite_gallery.py --keys "" one --plot docs/suite-gallery.png

Prints the scores, and the rank correlations of students between the first key and each other one. `--cards FOLDER`
writes the cards of the first key.
"""

import argparse
import time
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import spearmanr

from llf_teacher.students.parsing import STUDENTS, parse_student
from llf_teacher.suite import Card, all_experiments, take

OTHERS = {
    "reasoner": ("reasoner(worlds=64)", "reasoner(worlds=4, forget=False)"),  # 256 worlds take long
    "obedient": (
        "obedient",
        "obedient(forget=False)",
        "obedient | forgetful(half_life=2)",
        "obedient | mishears(p=0.3)",
        "obedient | stubborn(p=0.3)",
    ),
    "text_only": ("text_only", "text_only(forget=False)"),
    "q_learning": ("q_learning", "q_learning(trust=0.8)"),
}
"""By name, in place of the default."""
LEAST = 5
"""Students with a score, below which there is no rank correlation."""
DISTINCT = 3
"""Different scores, below which there is none, too."""
SHOWN = -1.0, 2.0
"""The scores on an axis."""
COLUMNS = 4
"""Axes in a row."""


def students() -> list[str]:
    """The specs of the students that can play without a model and without an extra; says which cannot."""
    found = []
    for name in STUDENTS.names:
        try:
            for spec in OTHERS.get(name, (name,)):
                parse_student(spec).check({})
                found.append(spec)
        except (ValueError, TypeError, ModuleNotFoundError) as error:
            print(f"Left out: {name}: {error}")
    return found


def scores(cards: Sequence[Card]) -> NDArray[np.float64]:
    """Shape (students, abilities); NaN where none was measured."""
    return np.array([[each.score for each in card.lines] for card in cards], dtype=float)


def alike(first: NDArray[np.float64], second: NDArray[np.float64]) -> str:
    """The rank correlation of scores that are on both sides, as text."""
    both = np.isfinite(first) & np.isfinite(second)
    if both.sum() < LEAST or min(len(np.unique(each[both].round(9))) for each in (first, second)) < DISTINCT:
        return f"none ({both.sum()} students)"
    return f"{spearmanr(first[both], second[both]).statistic:.3f} ({both.sum()})"


def table(cards: Sequence[Card]) -> str:
    """The scores in Markdown; empty: not measured."""
    names = [each.name for each in cards[0].lines]
    lines = [["student", *names], ["---"] * (len(names) + 1)]
    for card in cards:
        spec = card.student.replace("|", "\\|")  # in a table
        lines.append([f"`{spec}`", *("" if e.score is None else f"{e.score:.2f}" for e in card.lines)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plot(cards: Sequence[Card]) -> Figure:
    """An axis for each ability, with a dot and an interval for each card."""
    names, rows = [each.name for each in cards[0].lines], range(len(cards))
    height = -(-len(names) // COLUMNS)
    figure = Figure(figsize=(13, 1.2 + 0.21 * len(cards) * height), layout="constrained")
    axes = figure.subplots(height, COLUMNS, sharey=True)
    for ax, name, i in zip(axes.flat, names, range(len(names)), strict=False):
        for row, line in zip(rows, (card.lines[i] for card in cards), strict=True):
            if line.score is None:
                continue
            if line.low is not None and line.high is not None:
                ax.plot(np.clip([line.low, line.high], *SHOWN), [row, row], color="C0", linewidth=1.6)
            beyond = "<" if line.score < SHOWN[0] else ">" if line.score > SHOWN[1] else "o"
            ax.plot(np.clip(line.score, *SHOWN), row, beyond, color="C0", markersize=4)
        for value, style in ((0, "-"), (1, ":")):
            ax.axvline(value, color="0.6", linewidth=0.8, linestyle=style, zorder=0)
        ax.set(title=name, xlim=(SHOWN[0] - 0.1, SHOWN[1] + 0.1), ylim=(len(cards) - 0.5, -0.5))
        ax.set_yticks(rows, [card.student for card in cards], fontsize=8)
        ax.grid(axis="y", linewidth=0.3)
    for ax in axes.flat[len(names) :]:
        ax.set_axis_off()
    figure.suptitle("0: none of it, 1: as the reference; no dot: not measured; triangle: beyond the axis")
    return figure


def main() -> None:
    """Take the suite by each student, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=Path("suite-gallery.db"), help="file; others by key")
    parser.add_argument("--keys", nargs="+", default=[""], help="texts from which seeds are drawn; empty: the suite's")
    parser.add_argument("--only", nargs="+", default=[], help="specs of students; all without it")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--cards", type=Path, help="folder for the cards, as JSON and Markdown")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    specs = args.only or students()
    taken: Mapping[str, list[Card]] = {key: [] for key in args.keys}
    for key, cards in taken.items():
        began = time.process_time(), time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # students that cannot play a family are not measured there
            store = args.store.with_stem(f"{args.store.stem}-{key}") if key else args.store
            cards += [take(spec, store, key=key, workers=args.workers) for spec in specs]
        used = time.process_time() - began[0], time.perf_counter() - began[1]
        print(
            f"Key {key!r}: {len(cards)} students, {used[0]:.0f} CPU seconds of this process, {used[1]:.0f} s",
            flush=True,
        )
    first = taken[args.keys[0]]
    print(f"\n{table(first)}\n")
    for key in args.keys[1:]:
        one, other = scores(first), scores(taken[key])
        print(f"Rank correlation of {args.keys[0]!r} and {key!r}, all scores: {alike(one, other)}")
        for i, name in enumerate(all_experiments()):
            print(f"- {name}: {alike(one[:, i], other[:, i])}")
    if args.cards is not None:
        args.cards.mkdir(parents=True, exist_ok=True)
        for number, card in enumerate(first):
            for suffix in (".json", ".md"):
                card.write(args.cards / f"{number:02}{suffix}")
    if args.plot is not None:
        plot(first).savefig(args.plot, dpi=90)


if __name__ == "__main__":
    main()
