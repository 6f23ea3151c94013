"""The best learned teacher beside the rule `near mistakes`, with the same information, budget and students.

The rule of the verdict, which was written before any of the lifetimes that it judges:

- Compared are a learned teacher and `near mistakes`. Both see the same 14 numbers of a decision, have the same budget,
  and teach the same students in the same houses.
- Trainings may be of any kind and number. Of all trainings for a budget the one is taken with which students waste
  least in 500 lifetimes from seed 2,000,000 on; there the number of moves of `near mistakes` is chosen, too.
- Both then teach 500 lifetimes with the seeds 5,000,000 to 5,000,499, which no training, choice or earlier comparison
  has had.
- The statistic is the regret per episode with `near mistakes` less that with the learned teacher, paired by lifetime:
  its mean with Student's 95 % interval, and p of a sign-flip test, adjusted by Holm's method over all rows of a table.
- The verdict is `wins` or `loses` if the adjusted p is below 0.05; else `equal` if the interval lies within 0.5 moves
  of 0; else `undecided`.
- Other students: the same for each pair of students, those trained with and those tested with. The training and the
  number of moves are chosen with the students trained with.
- Levels: a teacher that chooses how many bits the next claim says, beside the best teacher that always says the same
  number of bits, chosen on lessons from seed 2,000,000 on. The same budget, students, seeds, statistic and verdict, by
  regret in a lesson.

This file is about budgets and other students, `choose_bits.py` about levels. Without the store all lifetimes are lived;
then the tables are printed. Needs the extra `learn`, of it `cma` alone:

    python examples/beside_a_rule.py --store docs/beside-a-rule.jsonl --plot docs/beside-a-rule.png
"""

import argparse
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _teacher_seats import ADVICE, SETTING, TRIAL, Policy, accompanied, keywords, look, near_mistakes
from search_a_teacher import CASES, LEARNED, NEAR, Line, Weighed, listed, over_trainings, read

import llf_teacher
from llf_teacher.studies.analysis.statistics import Difference, holm, mean_interval, paired_differences

FINAL, LIFETIMES = 5_000_000, 500
"""First seed and number of the lifetimes that the verdict is about."""
MARGIN, LEVEL = 0.5, 0.05
"""Moves an episode within which teachers are equal, and greatest adjusted p of a difference."""
TRAININGS = Path(__file__).parent.parent / "docs" / "search-a-teacher.jsonl"
"""What `search_a_teacher.py` has trained."""
BUDGETS = tuple(f"budget {budget}" for budget in (2, 4, 8, 16, 32))
PLAIN, DRAWN = "budget 8", "students drawn"
"""Cases of students trained with: all alike, or each lifetime's with its own step size, discount and trust."""
NAMES = {PLAIN: "all alike", DRAWN: "drawn"}
TRAITS = ("stubborn(p=0.3)", "forgetful(half_life=400)")
"""Of students tested with, beside those."""


def judge(gains: Sequence[np.ndarray]) -> list[tuple[Difference, float, str]]:
    """What the learned teacher saves beside the other one, its adjusted p and the verdict.

    Args:
        gains: of each row of a table, what it saves in each lifetime, shape (lifetimes,).
    """
    differences = paired_differences(gains)
    adjusted = holm([each.p for each in differences])
    return [(each, p, _verdict(each, p)) for each, p in zip(differences, adjusted, strict=True)]


def _verdict(difference: Difference, p: float) -> str:
    mean, low, high = difference.estimate[:3]
    if p < LEVEL:
        return "wins" if mean > 0 else "loses"
    return "equal" if low > -MARGIN and high < MARGIN else "undecided"


class Rivals(NamedTuple):
    """The best on trial of the trainings of a case, and the rule with the best number of moves."""

    moves: int
    training: int
    """Its number."""
    teachers: Weighed
    weights: np.ndarray
    """Of all trainings, shape (trainings, k)."""

    @classmethod
    def of(cls, case: str, lifetimes: int) -> "Rivals":
        """Those of a case, by so many lifetimes on trial."""
        trial, setting = range(TRIAL, TRIAL + lifetimes), CASES[case].setting
        moves = min(range(1, 11), key=lambda each: accompanied(near_mistakes(moves=each), setting, trial).mean())
        lines = [line for line in read(TRAININGS) if line["case"] == case and LEARNED in line]
        teachers, weights = Weighed(CASES[case]), np.array([line["weights"] for line in lines])
        wasted = teachers.live(weights, [TRIAL] * len(weights), lifetimes).mean(axis=1)
        return cls(moves, int(wasted.argmin()), teachers, weights)

    def policy(self, training: int) -> Policy:
        """What a training came to."""
        return lambda seen: self.teachers.speaks(self.weights[training], seen)

    def policies(self) -> Mapping[str, Policy]:
        """The rule and the best training by name."""
        return {NEAR: near_mistakes(moves=self.moves), LEARNED: self.policy(self.training)}


def of_budgets(lifetimes: int) -> Iterator[Line]:
    """What students waste with both, by budget; and the mean of each training."""
    for case in BUDGETS:
        rivals, setting = Rivals.of(case, lifetimes), CASES[case].setting
        line: Line = {"case": case, "moves": rivals.moves, "training": rivals.training}
        seeds = range(FINAL, FINAL + lifetimes)
        line[NEAR] = listed(accompanied(near_mistakes(moves=rivals.moves), setting, seeds))
        lives = [accompanied(rivals.policy(i), setting, seeds) for i in range(len(rivals.weights))]
        yield line | {LEARNED: listed(lives[rivals.training]), "trainings": listed(np.mean(lives, axis=1))}


def of_students(lifetimes: int) -> Iterator[Line]:
    """The same at a budget of 8, by students trained with and tested with."""
    seeds, by_moves = range(FINAL, FINAL + lifetimes), dict[tuple[str, int], list[float]]()
    for trained in (PLAIN, DRAWN):
        rivals = Rivals.of(trained, lifetimes)
        for tested in (PLAIN, DRAWN, *TRAITS):
            line: Line = {"trained": NAMES[trained], "tested": NAMES.get(tested, tested)}
            line |= {"moves": rivals.moves, "training": rivals.training}
            for name, policy in rivals.policies().items():
                if name == NEAR and (tested, rivals.moves) in by_moves:
                    line[name] = by_moves[tested, rivals.moves]
                elif tested in CASES:
                    line[name] = listed(accompanied(policy, CASES[tested].setting, seeds))
                else:
                    line[name] = listed(one_by_one(policy, f"{SETTING.student} | {tested}", seeds))
            by_moves[tested, rivals.moves] = line[NEAR]
            yield line


def one_by_one(policy: Policy, student: str, seeds: Iterable[int]) -> np.ndarray:
    """As `accompanied`, in the scalar game, whose students have traits."""
    env = llf_teacher.TeacherEnv(SETTING.id, **keywords(SETTING._replace(student=student)))
    regrets = []
    for seed in seeds:
        observation, _ = env.reset(seed=seed)
        regrets.append(0.0)
        done = False
        while not done:
            seen, decides = look(observation)
            speaks = decides and np.all(policy(seen[None]))
            observation, reward, terminated, truncated, _ = env.step(ADVICE if speaks else 0)
            regrets[-1] -= float(reward)
            done = terminated or truncated
    return np.array(regrets) / SETTING.episodes


def table(lines: Sequence[Line], first: Sequence[str]) -> list[str]:
    """Per row, named by the entries `first`, regret per episode with both, and the verdict."""
    extra = "; by trainings" if "trainings" in lines[0] else ""
    rows = [f"| {' | '.join(first)} | {NEAR} | {LEARNED} | less with the learned one{extra} | p | verdict |"]
    rows.append("|---" * (len(first) + 5) + "|")
    judged = judge([np.array(line[NEAR]) - np.array(line[LEARNED]) for line in lines])
    for line, (gain, p, verdict) in zip(lines, judged, strict=True):
        cells = [line[name] for name in first]
        cells += [f"{mean_interval(line[NEAR]).text()} ({line['moves']})", mean_interval(line[LEARNED]).text()]
        spread = f"; {over_trainings(np.mean(line[NEAR]) - np.array(line['trainings']))}" if extra else ""
        rows.append(f"| {' | '.join([*cells, gain.estimate.text() + spread, f'{p:.4f}', verdict])} |")
    return rows


def draw(tables: Sequence[Sequence[Line]], path: str) -> None:
    """What the learned teachers save beside the rule, with 95 % intervals; open dots are undecided."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 1.2 + 0.3 * sum(map(len, tables))), layout="constrained")
    axes, names = figure.subplots(), list[str]()
    for lines in tables:
        judged = judge([np.array(line[NEAR]) - np.array(line[LEARNED]) for line in lines])
        for line, (gain, _, verdict) in zip(lines, judged, strict=True):
            mean, low, high = gain.estimate[:3]
            row = len(names)
            axes.plot((low, high), (row, row), color="0.2", linewidth=1.5)
            axes.plot(mean, row, "o", color="0.2", markerfacecolor="white" if verdict == "undecided" else "0.2")
            axes.annotate(verdict, (1.01, row), xycoords=("axes fraction", "data"), va="center")
            names.append(line["case"] if "case" in line else f"{line['trained']}, then {line['tested']}")
    axes.axvspan(-MARGIN, MARGIN, color="0.92", zorder=0)
    axes.axvline(0, color="0.6", zorder=0, linewidth=1)
    axes.set(yticks=range(len(names)), yticklabels=names, xlabel="regret per episode, less than near mistakes")
    axes.invert_yaxis()
    figure.savefig(path, dpi=110)


def main() -> None:
    """Live what the store lacks; print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lifetimes", type=int, default=LIFETIMES, help="to choose by, and to compare on")
    parser.add_argument("--store", type=Path, required=True, help="file of JSON lines")
    parser.add_argument("--plot", help="file for the figure")
    arguments = parser.parse_args()
    if not arguments.store.exists():
        with arguments.store.open("w", encoding="utf-8") as file:
            for line in (*of_budgets(arguments.lifetimes), *of_students(arguments.lifetimes)):
                file.write(json.dumps(line) + "\n")
    lines = read(arguments.store)
    by_budget = [line for line in lines if "case" in line]
    others = [line for line in lines if "trained" in line]
    print("\n".join([*table(by_budget, ["case"]), "", *table(others, ["trained", "tested"])]))
    if arguments.plot:
        draw([by_budget, others], arguments.plot)


if __name__ == "__main__":
    main()
