"""Whether the suite measures what it says: the score that each of ten known defects costs in each experiment.

    python examples/check_suite.py --plot docs/suite.png

A student with all abilities gets a trait that takes one away, at three strengths. At full strength the score of that
ability should fall by 0.8 of it at least, and no other by more than 0.2, but those that rest on it. The whole is done
again with other seeds.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.stats import spearmanr

from llf_teacher.suite import all_experiments, take

WHOLE = "reasoner(worlds=16)"
DEFECTS = {
    "advice": ("skims(kinds='fp', p={})", (1 / 3, 2 / 3, 1)),
    "warnings": ("skims(kinds='fn', p={})", (1 / 3, 2 / 3, 1)),
    "praise": ("skims(kinds='hp', p={})", (1 / 3, 2 / 3, 1)),
    "blame": ("skims(kinds='hn', p={})", (1 / 3, 2 / 3, 1)),
    "late": ("defects:MissesThePast(p={})", (1 / 3, 2 / 3, 1)),
    "hints": ("defects:MissesHints(p={})", (1 / 3, 2 / 3, 1)),
    "silence": ("defects:ForgetsInSilence(p={})", (0.05, 0.2, 1)),  # in each of ten turns
    "voice": ("defects:MissesTone(p={})", (1 / 3, 2 / 3, 1)),
    "truisms": ("defects:Distracted(p={})", (1 / 3, 2 / 3, 1)),
    "turncoat": ("capitulates(after={})", (4, 2, 0)),
}
"""By ability the trait that takes it away, and three strengths, the weakest first."""
LEAST, MOST = 0.8, 0.2


def scores_of(spec: str, names: tuple[str, ...], store: Path, key: str, quick: bool, workers: int) -> dict[str, float]:
    """The scores of a student by ability; NaN where none was measured."""
    card = take(spec, store, names, quick, key, workers)
    return {each.name: np.nan if each.score is None else each.score for each in card.lines}


def measure(store: Path, key: str, quick: bool, workers: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The scores, and those of each defect's own ability by strength.

    Returns:
        Scores without a defect and with each at full strength, shape (1 + defects, abilities); scores by strength from
        none on, shape (defects, 4).
    """
    names = tuple(all_experiments())
    specs = {
        name: [f"{WHOLE} | {trait.format(each)}" for each in strengths] for name, (trait, strengths) in DEFECTS.items()
    }
    rows = [
        scores_of(each, names, store, key, quick, workers) for each in (WHOLE, *(specs[name][-1] for name in names))
    ]
    by_strength = [
        [
            rows[0][name],
            *(scores_of(each, (name,), store, key, quick, workers)[name] for each in specs[name][:-1]),
            row[name],
        ]
        for name, row in zip(names, rows[1:], strict=True)
    ]
    return np.array([[row[name] for name in names] for row in rows]), np.array(by_strength)


def faults(scores: NDArray[np.float64], by_strength: NDArray[np.float64]) -> list[str]:
    """What is not as it should be."""
    names = list(all_experiments())
    found = []
    for i, defect in enumerate(names):
        lost = scores[0] - scores[1 + i]
        if not lost[i] >= LEAST * scores[0, i]:
            found.append(f"{defect}: its defect takes {lost[i]:.2f} of {scores[0, i]:.2f}")
        if np.isnan(by_strength[i]).any() or (np.diff(by_strength[i]) > 0).any():
            found.append(f"{defect}: the score does not fall with strength")
        for j, other in enumerate(names):
            if j != i and not lost[j] <= MOST and defect not in bases(other):
                found.append(f"{other}: falls by {lost[j]:.2f} without {defect}, and does not declare it")
    return found


def bases(name: str) -> set[str]:
    """What an experiment rests on, directly or not."""
    direct = set(all_experiments()[name].rests_on)
    return direct.union(*map(bases, direct))


def table(scores: NDArray[np.float64], by_strength: NDArray[np.float64]) -> str:
    """In Markdown the score without a defect, what each takes at full strength, and its own score by strength."""
    names = list(all_experiments())
    lines = [["without", *names, "own score by strength"], ["---"] * (len(names) + 2)]
    lines.append(["none (score)", *(f"{each:.2f}" for each in scores[0]), ""])
    for i, name in enumerate(names):
        lost = [f"{each:.2f}" for each in scores[0] - scores[1 + i]]
        lost[i] = f"**{lost[i]}**"
        lines.append([name, *lost, ", ".join(f"{each:.2f}" for each in by_strength[i])])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plot(scores: NDArray[np.float64]) -> Figure:
    """The matrix of scores lost; a cell in a frame is declared."""
    names = list(all_experiments())
    lost = scores[0] - scores[1:]
    figure = Figure(figsize=(7.6, 6.4), layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(lost, cmap="RdBu_r", vmin=-1.2, vmax=1.2)
    for (i, j), value in np.ndenumerate(lost):
        axes.text(j, i, f"{value:.2f}", ha="center", va="center", color="white" if abs(value) > 0.8 else "black")
        if i == j or names[i] in bases(names[j]):
            axes.add_patch(_frame(j, i, 2.0 if i == j else 0.8))
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="experiment", ylabel="ability that the defect takes away")
    figure.colorbar(image, label="score lost", shrink=0.8)
    return figure


def _frame(x: int, y: int, width: float) -> Rectangle:
    return Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, edgecolor="black", linewidth=width)


def main() -> None:
    """Measure, and print the matrix, its faults, and how alike both runs are."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=Path("check-suite.db"))
    parser.add_argument("--keys", nargs="+", default=["one", "two"], help="texts from which seeds are drawn")
    parser.add_argument("--quick", action="store_true", help="fewer seeds")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    runs = [measure(args.store, key, args.quick, args.workers) for key in args.keys]
    print(f"\n{table(*runs[0])}\n")
    for key, run in zip(args.keys, runs, strict=True):
        print(f"Faults with {key}:", "; ".join(faults(*run)) or "none")
    for key, (scores, _) in list(zip(args.keys, runs, strict=True))[1:]:
        both = np.isfinite(scores) & np.isfinite(runs[0][0])
        alike = spearmanr(scores[both], runs[0][0][both]).statistic
        print(f"Rank correlation of all scores with {args.keys[0]} and {key}: {alike:.3f}")
    if args.plot is not None:
        plot(runs[0][0]).savefig(args.plot, dpi=110)


if __name__ == "__main__":
    main()
