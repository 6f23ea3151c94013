"""Do late words cost a student more, or wrong ones? A question of ours: two turns late, or wrong in three of ten.

Declared before, as `compare` of the study `late_or_wrong.toml`: the late teacher beside the wrong one, over all
families; each family is tested too, with Holm's correction. A seed's score is its regret with the late teacher less
that with the wrong one, over the sum of both mean regrets in the family: above 0 late words cost more, below 0 wrong
ones. Over all families it is the mean of their scores.

Plays what a store lacks of the study, prints a table and draws it:

    python examples/known_results/late_or_wrong.py --plot docs/late-or-wrong.png
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.studies import run
from llf_teacher.studies.analysis.statistics import Estimate, holm, paired_difference
from llf_teacher.studies.definition.study import load_study

FILE = Path(__file__).with_suffix(".toml")
LATE, WRONG, ALL = "delayed(turns=2)", "mistake(eps=0.3)", "all families"
TASKS = {
    "metaworld": "robot arm",
    "parking": "car park",
    "optimization": "loss function",
    "alfworld": "household",
    "poem": "haiku",
    "gridworld": "treasure hunt",
    "movies": "film tips",
    "bandits": "ten-armed bandit",
}


class Line(NamedTuple):
    """A family, or all of them."""

    name: str
    late: float
    """Mean regret."""
    wrong: float
    score: Estimate
    p: float
    """Of the sign-flip test; of families after Holm's correction for the eight of them."""


def lines(rows: list[dict[str, Any]]) -> list[Line]:
    """All families together, then each, from late words that cost most to wrong ones that do."""
    families = sorted({row["family"] for row in rows})
    regrets = {key: [] for key in ((family, teacher) for family in families for teacher in (LATE, WRONG))}
    for row in sorted(rows, key=lambda row: row["seed"]):
        if (key := (row["family"], row["teacher"])) in regrets:
            regrets[key].append(row["regret"])
    late, wrong = (np.array([regrets[family, teacher] for family in families]) for teacher in (LATE, WRONG))
    scale = (late.mean(axis=1) + wrong.mean(axis=1))[:, None]
    differences = [paired_difference(*pair) for pair in zip(late / scale, wrong / scale, strict=True)]
    adjusted = holm([each.p for each in differences])
    apart = [
        Line(family, float(late[i].mean()), float(wrong[i].mean()), differences[i].estimate, adjusted[i])
        for i, family in enumerate(families)
    ]
    together = paired_difference((late / scale).mean(axis=0), (wrong / scale).mean(axis=0))
    nan = float("nan")
    return [
        Line(ALL, nan, nan, together.estimate, together.p),
        *sorted(apart, key=lambda line: -line.score.mean),
    ]


def verdict(found: list[Line], seeds: int) -> str:
    """What costs more over all families, and in how many of them, each by its test at 0.05."""

    def side(line: Line) -> str:
        return "open" if not line.p <= 0.05 else "late" if line.score.mean > 0 else "wrong"

    whole, *families = found
    words = {"late": "late words cost more", "wrong": "wrong words cost more", "open": "open"}[side(whole)]
    sides = [side(line) for line in families]
    number = ", ".join(f"{each} in {sides.count(each)}" for each in ("late", "wrong", "open") if each in sides)
    return f"Verdict: {words} over all families (score {whole.score.text(2)}, {seeds} seeds); of families {number}"


def draw(found: list[Line], path: Path) -> None:
    """A dot a row with its interval; a hollow dot has none."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 3.5), layout="constrained")
    axes = figure.subplots()
    for place, line in enumerate(found):
        score = line.score
        colour = "0.45" if line.p > 0.05 else "#0b62a4" if score.mean > 0 else "#b3541e"
        if not score.why:
            axes.plot([score.low, score.high], [place, place], color=colour, linewidth=2.5, solid_capstyle="round")
        filled = colour if not score.why else "white"
        axes.plot(score.mean, place, "o", color=colour, markerfacecolor=filled, markersize=8 if place else 10)
    axes.axvline(0, color="0.2", linewidth=1)
    axes.axhline(0.5, color="0.8", linewidth=1)
    names = [f"{line.name}: {TASKS[line.name]}" if line.name in TASKS else line.name for line in found]
    axes.set(yticks=range(len(found)), yticklabels=names, xlim=(-1, 1), xticks=[-1, -0.5, 0, 0.5, 1])
    axes.invert_yaxis()
    axes.tick_params(axis="y", length=0)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.set_xlabel("← wrong words cost more        score        late words cost more →")
    figure.savefig(path, dpi=140)


def main() -> None:
    """Play what the store lacks, print the table, draw the plot."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seeds", type=int, help="fewer than the study's")
    parser.add_argument(
        "--store", type=Path, default=Path("late-or-wrong.db"), help="file of the episodes; by default late-or-wrong.db"
    )
    parser.add_argument("--workers", type=int, help="processes; by default one a core")
    parser.add_argument("--plot", type=Path, help="file to draw to")
    given = parser.parse_args()
    study = load_study(FILE)
    if given.seeds:
        study = replace(study, seeds=tuple(range(given.seeds)))
    with run(study, given.store, workers=given.workers) as results:
        found = lines(list(results.rows()))
    print("| family | regret, late | regret, wrong | score | p |\n|---|---|---|---|---|")
    for line in found:
        regrets = "|  |  |" if line.name == ALL else f"| {line.late:.2f} | {line.wrong:.2f} |"
        p = "< 0.001" if line.p < 0.001 else f"{line.p:.3f}"
        print(f"| {line.name} {regrets} {line.score.text(2)} | {p} |")
    print(f"\n{verdict(found, len(study.seeds))}")
    if given.plot:
        draw(found, given.plot)


if __name__ == "__main__":
    main()
