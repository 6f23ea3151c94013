"""Whether the mirror measures what it says: the score that each defect of a teacher costs in each quality.

    python examples/check_mirror.py --plot docs/suite-teachers.png

A sound teacher gets a defect that takes one quality away, at three strengths. At full strength the score of that
quality should fall by 0.8 of it at least, and no other by more than 0.2, but those that rest on it. With two `--keys`
the whole is done again with other seeds; then the scores of both should have a rank correlation of 0.95 at least.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.stats import spearmanr

from llf_teacher.suite.mirror import all_qualities, take


class Lack(NamedTuple):
    """A sound teacher, what takes a quality from it, and three strengths of that, the weakest first."""

    sound: str
    defect: str
    strengths: tuple[float, float, float] = (1 / 3, 2 / 3, 1.0)


_CORRECTS = "mistake_correcting(budget=100, threshold=0.0)"
_ADVISES = f"only(kinds='fp') | {_CORRECTS}"
DEFECTS = {
    "truth": Lack(_ADVISES, "mistake(eps={})"),  # blind: takes another world for this one
    "calibration": Lack("partial", "overconfident(by={})", (3.0, 10.0, 100.0)),
    "worth": Lack(_ADVISES, "verbose(k={})", (1, 3, 20)),
    "use": Lack(_ADVISES, "defective_teachers:Riddling(p={})"),
    "timing": Lack(_ADVISES, "delayed(turns={})", (1, 3, 9)),
    "news": Lack("ruler", "defective_teachers:Repeating(p={})"),
    "adapts": Lack(_ADVISES, "defective_teachers:AlwaysAdvising(p={})"),
    "fades": Lack(_ADVISES, "defective_teachers:NeverFading(p={})"),
    "pushback": Lack(_CORRECTS, "defective_teachers:Flattering(p={})"),
    "remains": Lack("ruler", "defective_teachers:ShortSighted(p={})"),
    "hints": Lack("ruler", "defective_teachers:AnswerGiving(p={})"),
}
LEAST, MOST, ALIKE = 0.8, 0.2, 0.95
Scores = NDArray[np.float64]


def measure(store: Path, key: str, worlds: int, workers: int) -> tuple[Scores, Scores, Scores]:
    """The scores of sound teachers and with each defect, shape (defects, qualities), and each defect's by strength.

    The last has the shape (defects, 4), from none on.
    """
    names = tuple(all_qualities())

    def scores_of(spec: str, *which: str) -> list[float]:
        card = take(spec, store, which, key=key, workers=workers, worlds=worlds)
        return [np.nan if each.score is None else each.score for each in card.lines]

    lacks = [DEFECTS[name] for name in names]
    specs = [[lack.sound, *(f"{lack.sound} | {lack.defect.format(each)}" for each in lack.strengths)] for lack in lacks]
    by_strength = []
    for name, row in zip(names, specs, strict=True):
        by_strength.append([scores_of(each, name)[0] for each in row])
        print(f"{key}: {name} by strength {np.round(by_strength[-1], 2)}", flush=True)
    found = []
    for name, row in zip(names, specs, strict=True):
        found.append([scores_of(row[0], *names), scores_of(row[-1], *names)])
        print(f"{key}: without {name} {np.round(np.subtract(*found[-1]), 2)}", flush=True)
    sound, spoilt = np.array(found).swapaxes(0, 1)
    return sound, spoilt, np.array(by_strength)


def faults(sound: Scores, spoilt: Scores, by_strength: Scores) -> list[str]:
    """What is not as it should be."""
    qualities = all_qualities()
    names, found = list(qualities), []
    for i, defect in enumerate(names):
        lost = sound[i] - spoilt[i]
        if not lost[i] >= LEAST * sound[i, i]:
            found.append(f"{defect}: its defect takes {lost[i]:.2f} of {sound[i, i]:.2f}")
        if np.isnan(by_strength[i]).any() or (np.diff(by_strength[i]) > 0).any():
            found.append(f"{defect}: the score does not fall with strength")
        found += [
            f"{other}: falls by {lost[j]:.2f} without {defect}, and does not declare it"
            for j, other in enumerate(names)
            if j != i and lost[j] > MOST and defect not in qualities[other].rests_on
        ]
    return found


def table(sound: Scores, spoilt: Scores, by_strength: Scores) -> str:
    """In Markdown what each defect takes of each score, and its own score by strength; `-` was not measured."""
    names = list(all_qualities())
    lines = [["without", *names, "own score by strength"], ["---"] * (len(names) + 2)]
    for i, name in enumerate(names):
        lost = [f"{each:.2f}" if np.isfinite(each) else "-" for each in sound[i] - spoilt[i]]
        lost[i] = f"**{lost[i]}**"
        lines.append([name, *lost, ", ".join(f"{each:.2f}" for each in by_strength[i])])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plot(sound: Scores, spoilt: Scores) -> Figure:
    """The matrix of scores lost; a cell in a frame is declared, an empty one was not measured."""
    qualities = all_qualities()
    names, lost = list(qualities), sound - spoilt
    figure = Figure(figsize=(7.6, 6.4), layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(lost, cmap="RdBu_r", vmin=-1.2, vmax=1.2)
    for (i, j), value in np.ndenumerate(lost):
        if np.isfinite(value):
            axes.text(j, i, f"{value:.2f}", ha="center", va="center", color="white" if abs(value) > 0.8 else "black")
        if i == j or names[i] in qualities[names[j]].rests_on:
            width = 2.0 if i == j else 0.8
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor="black", linewidth=width))
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="quality that is measured", ylabel="quality that the defect takes away")
    figure.colorbar(image, label="score lost", shrink=0.8)
    return figure


def main() -> None:
    """Measure, and print the matrix, its faults, and how alike two runs are."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=Path("check-mirror.db"))
    parser.add_argument("--keys", nargs="+", default=["one"], help="texts from which seeds are drawn")
    parser.add_argument("--worlds", type=int, default=20, help="number of worlds, 5 to 20")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    runs = [measure(args.store, key, args.worlds, args.workers) for key in args.keys]
    print(f"\n{table(*runs[0])}\n")
    for key, run in zip(args.keys, runs, strict=True):
        print(f"Faults with {key}:", "; ".join(faults(*run)) or "none")
    for key, run in list(zip(args.keys, runs, strict=True))[1:]:
        one, other = (np.concatenate([each.ravel() for each in both[:2]]) for both in (runs[0], run))
        both = np.isfinite(one) & np.isfinite(other)
        rho = spearmanr(one[both], other[both]).statistic
        said = "alike" if rho >= ALIKE else f"not alike: below {ALIKE}"
        print(f"Rank correlation of {both.sum()} scores with {args.keys[0]} and {key}: {rho:.3f}, {said}")
    if args.plot is not None:
        plot(*runs[0][:2]).savefig(args.plot, dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
