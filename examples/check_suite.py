"""Whether the suite measures what it says: the score that known defects cost in each experiment.

    python examples/check_suite.py --keys sorrel cedar --pairs --plot docs/suite.png

A student with an ability gets a trait that takes it away, at three strengths. At full strength the score of that
ability should fall by 0.8 of it at least, and no other by more than 0.2, but those that rest on it. With `--pairs` each
two of these traits are tried together, with the first key. An ability of a pair that rests on the other is not judged:
without advice there is nothing left to be confused about, and so `voice`, `truisms` and `turncoat` may rise.

Then it is asked whether both families of an experiment order all these students and the scripted ones alike: of the
pairs that differ significantly in both, how many are in the same order in both, less how many are not, as a share of
all of them (the gamma of Goodman and Kruskal, 1954, where what is not significant is a tie). It should be above 0.5,
by 5 pairs at least, over all keys.
"""

import argparse
import warnings
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from scipy.stats import ttest_1samp
from suite_gallery import students

from llf_teacher.studies import load, run
from llf_teacher.studies.definition.custom_specs import student_spec
from llf_teacher.suite import all_experiments, studies_of
from llf_teacher.suite.score import ALPHA
from llf_teacher.suite.taking import arms_of, scored, seeds_of

WHOLE, REMEMBERING = "reasoner(worlds=4, forget=False)", "obedient(forget=False)"
"""A student that weighs worlds by all that is said, and one that recalls what was said of a world."""
DEFECTS = {
    "advice": ("skims(kinds='fp', p={})", (1 / 3, 2 / 3, 1)),
    "warnings": ("skims(kinds='fn', p={})", (1 / 3, 2 / 3, 1)),
    "praise": ("skims(kinds='hp', p={})", (1 / 3, 2 / 3, 1)),
    "blame": ("skims(kinds='hn', p={})", (1 / 3, 2 / 3, 1)),
    "hints": ("_defects:MissesHints(p={})", (1 / 3, 2 / 3, 1)),
    "silence": ("_defects:ForgetsInSilence(p={})", (0.05, 0.2, 1)),  # in each of ten turns
    "recall": ("_defects:ForgetsLessons(p={})", (1 / 3, 2 / 3, 1)),
    "rules": ("_defects:MissesRules(p={})", (1 / 3, 2 / 3, 1)),
    "voice": ("_defects:MissesTone(p={})", (1 / 3, 2 / 3, 1)),
    "truisms": ("_defects:Distracted(p={})", (1 / 3, 2 / 3, 1)),
    "turncoat": ("capitulates(after={})", (4, 2, 0)),
}
"""By ability the trait that takes it away, and three strengths, the weakest first."""
ABLE = {
    REMEMBERING: ("advice", "warnings", "praise", "blame", "silence", "recall", "voice", "truisms"),
    WHOLE: ("advice", "warnings", "praise", "hints", "rules", "turncoat"),
}
"""By student the abilities that are taken away from it: from the second those that only it has, and some on which these
rest.
"""
LEAST, MOST = 0.8, 0.2
ALIKE, PAIRS = 0.5, 5
"""What gamma should exceed, and the number of pairs that it needs."""
Numbers = NDArray[np.float64]
ROWS = [(who, name) for who, names in ABLE.items() for name in names]
"""A student and the ability that it lacks."""


class Measured(NamedTuple):
    """Scores by row of `ROWS`; NaN where none was measured."""

    whole: Numbers
    """Without the defect, shape (rows, abilities)."""
    full: Numbers
    """With it at full strength, shape (rows, abilities)."""
    by_strength: Numbers
    """Of the own ability, by strength from none on, shape (rows, 4)."""

    @property
    def lost(self) -> Numbers:
        """What each defect costs."""
        return self.whole - self.full


class Scores:
    """The scores of students in the worlds of a key.

    Args:
        store: file of the episodes.
        key: text from which the seeds are drawn.
        worlds: number of seeds; None: those of the suite.
        workers: parallel processes.
    """

    def __init__(self, store: Path, key: str, worlds: int | None, workers: int) -> None:
        self._store, self._seeds, self._workers = store, seeds_of(key)[:worlds], workers
        self.costs = {name: list[Numbers]() for name in all_experiments()}
        """What the worse lessons cost each student beyond the better ones, shape (families, seeds)."""

    def of(self, specs: Sequence[str], names: Sequence[str]) -> Numbers:
        """By student and ability, shape (specs, names)."""
        asked, specs = {name: all_experiments()[name] for name in names}, [student_spec(each) for each in specs]
        studies = studies_of(specs, asked, self._seeds)
        for study in studies:
            run(study, self._store, self._workers if len(study.seeds) > 1 else 1).close()  # in a town few are played
        keys = {each.key for study in studies for each in study.episodes()}
        with load(self._store) as results:
            rows = [row for row in results.rows() if row["key"] in keys]
        found = [[scored(each, spec, rows, self._seeds) for each in asked.values()] for spec in specs]
        for spec, each_score in zip(specs, found, strict=True):
            for (name, each), score in zip(asked.items(), each_score, strict=True):
                if len(score.places) == len(each.ids):
                    arms = arms_of(each, spec, rows, self._seeds).values()
                    self.costs[name].append(np.array([arm.worse - arm.better for arm in arms]))
        return np.array([[score.score for score in each] for each in found], dtype=float)


def with_defects(who: str, *defects: str, strength: int = -1) -> str:
    """The spec of a student with defects."""
    return " | ".join((who, *(DEFECTS[name][0].format(DEFECTS[name][1][strength]) for name in defects)))


def measure(scores: Scores) -> Measured:
    """The scores without and with each defect."""
    names = list(all_experiments())
    whole, full, by_strength = [], [], []
    for who, lacking in ABLE.items():
        able, *others = scores.of([who, *(with_defects(who, name) for name in lacking)], names)
        for name, other in zip(lacking, others, strict=True):
            i = names.index(name)
            weaker = scores.of([with_defects(who, name, strength=each) for each in (0, 1)], [name])[:, 0]
            whole.append(able)
            full.append(other)
            by_strength.append([able[i], *weaker, other[i]])
    return Measured(np.array(whole), np.array(full), np.array(by_strength))


def bases(name: str) -> set[str]:
    """What an experiment rests on, directly or not."""
    direct = set(all_experiments()[name].rests_on)
    return direct.union(*map(bases, direct))


def wrong(lost: Numbers, whole: Numbers, defects: Sequence[str]) -> list[str]:
    """What is not as it should be with these defects together."""
    found, together = [], " and ".join(defects)
    for name, less, score in zip(all_experiments(), lost, whole, strict=True):
        rests = bool(bases(name).intersection(defects))
        if name in defects:
            if not rests and not less >= LEAST * score:
                found.append(f"{name}: without {together} it loses {less:.2f} of {score:.2f}")
        elif less > MOST and not rests:
            found.append(f"{name}: without {together} it loses {less:.2f}, and does not declare it")
    return found


def faults(run_: Measured) -> list[str]:
    """What is not as it should be with one defect."""
    found = []
    for (who, defect), lost, whole, own in zip(ROWS, run_.lost, run_.whole, run_.by_strength, strict=True):
        found += [f"{who}: {each}" for each in wrong(lost, whole, [defect])]
        if np.isnan(own).any() or (np.diff(own) > 0).any():
            found.append(f"{who}: {defect}: the score does not fall with strength")
    return found


def pairs(scores: Scores, who: str) -> tuple[int, list[str]]:
    """The number of pairs of a student's abilities, and what is not as it should be without both.

    Pairs are left out that a student before in `ABLE` has.
    """
    names = list(all_experiments())
    tried = [pair for pair in combinations(names, 2) if next(filter(set(pair).issubset, ABLE.values()), 0) is ABLE[who]]
    whole, *without = scores.of([who, *(with_defects(who, *pair) for pair in tried)], names)
    faulty = (wrong(whole - each, whole, pair) for each, pair in zip(without, tried, strict=True))
    return len(tried), [each for found in faulty for each in found]


def order(costs: Sequence[Numbers]) -> Numbers:
    """Numbers of pairs of students: in the same order in both families, in opposite order, and different in one only.

    A pair differs in a family by a t test over worlds; students that cost the same in every world are one.
    """
    different = np.unique(np.array(costs).round(9), axis=0)
    pairs = np.array([first - second for first, second in combinations(different, 2)])
    if not len(pairs):
        return np.zeros(3)
    differs = ttest_1samp(pairs, 0, axis=-1).pvalue < ALPHA
    both, alike = differs.all(axis=-1), pairs.mean(axis=-1).prod(axis=-1) > 0
    return np.array([(both & alike).sum(), (both & ~alike).sum(), (differs.sum(axis=-1) == 1).sum()], dtype=float)


def families(numbers: Mapping[str, Numbers]) -> str:
    """In Markdown how alike both families of each experiment order students."""
    lines = [["experiment", "same order", "opposite order", "in one family only", "gamma"], ["---"] * 5]
    for name, (same, opposite, one) in numbers.items():
        gamma = (same - opposite) / (same + opposite) if same + opposite >= PAIRS else np.nan
        verdict = "too few pairs" if np.isnan(gamma) else f"{gamma:.2f}" + ("" if gamma > ALIKE else ": not alike")
        lines.append([name, f"{same:.0f}", f"{opposite:.0f}", f"{one:.0f}", verdict])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def table(run_: Measured) -> str:
    """In Markdown what each defect takes at full strength, and its own score by strength."""
    names = list(all_experiments())
    lines = [["student", "without", *names, "own score by strength"], ["---"] * (len(names) + 3)]
    for (who, name), row, own in zip(ROWS, run_.lost, run_.by_strength, strict=True):
        lost = [f"**{each:.2f}**" if name == other else f"{each:.2f}" for other, each in zip(names, row, strict=True)]
        lines.append([who.partition("(")[0], name, *lost, ", ".join(f"{each:.2f}" for each in own)])
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plot(run_: Measured) -> Figure:
    """The matrix of scores lost; a cell in a frame is declared."""
    names = list(all_experiments())
    figure = Figure(figsize=(8.8, 8.2), layout="constrained")
    axes = figure.subplots()
    image = axes.imshow(run_.lost, cmap="RdBu_r", vmin=-1.2, vmax=1.2)
    for (i, j), value in np.ndenumerate(run_.lost):
        text = "" if np.isnan(value) else f"{value:.2f}"
        axes.text(j, i, text, ha="center", va="center", color="white" if abs(value) > 0.8 else "black")
        if ROWS[i][1] == names[j] or ROWS[i][1] in bases(names[j]):
            width = 2.0 if ROWS[i][1] == names[j] else 0.8
            axes.add_patch(Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor="black", linewidth=width))
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
    axes.set_yticks(range(len(ROWS)), [f"{who.partition('(')[0]} without {name}" for who, name in ROWS])
    axes.set(xlabel="experiment")
    figure.colorbar(image, label="score lost", shrink=0.8)
    return figure


def main() -> None:
    """Measure, and print the matrix and what is wrong with it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", type=Path, default=Path("check-suite.db"))
    parser.add_argument("--keys", nargs="+", default=["one"], help="texts from which seeds are drawn")
    parser.add_argument("--worlds", type=int, help="number of seeds; those of the suite without it")
    parser.add_argument("--pairs", action="store_true", help="also try each two defects together")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    warnings.simplefilter("ignore", RuntimeWarning)  # students that cannot play a family are not measured there
    others, numbers = students(), {name: np.zeros(3) for name in all_experiments()}
    for key in args.keys:
        measured = measure(scores := Scores(args.store, key, args.worlds, args.workers))
        print(f"\n{table(measured)}\n\nFaults with {key}:", "; ".join(faults(measured)) or "none", flush=True)
        scores.of(others, list(all_experiments()))
        for name, costs in scores.costs.items():
            numbers[name] += order(costs)
        if args.plot is not None and key == args.keys[0]:
            plot(measured).savefig(args.plot, dpi=110, bbox_inches="tight")
    print(f"\nPairs of students in both families:\n\n{families(numbers)}\n", flush=True)
    if args.pairs:
        scores = Scores(args.store, args.keys[0], args.worlds, args.workers)
        for who in ABLE:
            number, found = pairs(scores, who)
            print(f"Faults with {number} pairs of {who}:", "\n- ".join(["", *found]) if found else "none", flush=True)


if __name__ == "__main__":
    main()
