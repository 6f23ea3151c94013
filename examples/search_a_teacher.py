"""A teacher that begins with a rule and searches on, in many cases: budgets, students, worlds, numbers it cannot see.

The teacher is a weighted sum of what it sees, and speaks where that is positive. It begins as the best rule of nearness
(`near_mistakes` of `_teacher_seats.py`), and CMA-ES (Hansen 2016) varies the weights: each generation is tried in the
same houses, and the next one drawn around what wasted least. A training ends on a line of a file, which a second run
goes on with. Prints tables of what the file has. Needs the extra `learn`:

    python examples/search_a_teacher.py --store docs/search-a-teacher.jsonl --plot docs/search-a-teacher.png
"""

import argparse
import json
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from _teacher_seats import SETTING, TRIAL, Policy, Seats, accompanied, lived, near_mistakes
from scipy import stats
from teaching_on_a_budget import SETTINGS, Setting

from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval

try:
    import cma
except ModuleNotFoundError as error:
    raise SystemExit(f'{error}; install it by: pip install -e ".[learn]" -c constraints-learn.txt') from None

SEEN = ("turn", "reward", "importance", "left", "over", *FIELDS)
"""What a teacher sees; `left` is the share of the budget."""
USED = [SEEN.index(name) for name in SEEN if name not in ("over", "announced", "mistake")]  # those are always the same
SHARE, ADVISED, WAY = (SEEN.index(name) for name in ("left", "advised", "way"))
GROUPS = {
    "moment": ("turn", "reward", "importance"),
    "budget": ("left",),
    "progress": ("episode", "success", "optimal", "skill"),
    "place": ("visits", "advised"),
    "way": ("way",),
}
FIRST, FRESH = 60_000_000, 4_000_000
"""First seeds of the lifetimes to learn from, and to compare on; nothing was chosen on the latter."""
CANDIDATES, LIVES, TOGETHER = 12, 32, 5
"""Of a generation, lifetimes on which each of them is tried, and trainings in the same arrays."""
STAGES, SPREAD, STEEP, LEAST, ROUNDING = 5, 0.3, 2.0, 0.05, 1e-3
ALL, NEAR, ONCE, REACHED = "announced mistake", "near mistakes", "near, advised there once at most", "as far as reached"
LEARNED, LAST = "learned", "last iterate"
Line = dict[str, Any]
"""What a training came to, or the rules."""


class Case(NamedTuple):
    """What is varied."""

    setting: Setting = SETTING
    without: Sequence[str] = ()
    """Numbers that the teacher does not see."""
    trainings: int = 3
    """At most."""
    generations: int = 10


def student(**parameters: float) -> Case:
    """Another student."""
    told = ", ".join(f"{name}={value}" for name, value in parameters.items())
    return Case(SETTING._replace(student=SETTING.student.replace("alpha=0.5", told)))


def rooms(number: int) -> Case:
    """Another size."""
    return Case(SETTING._replace(world={**SETTING.world, "num_rooms": number}))


VARIED = {"alpha": (0.1, 0.9), "gamma": (0.8, 0.99), "trust": (0.5, 1.0)}
"""Students of whom each lifetime has its own."""
CASES: Mapping[str, Case] = {
    **{
        f"budget {budget}": Case(SETTING._replace(budget=budget), trainings=10, generations=20)
        for budget in (2, 4, 8, 16, 32)
    },
    "without way": Case(without=GROUPS["way"], generations=20),
    "alpha 0.2": student(alpha=0.2),
    "12 rooms": rooms(12),
    "trust 0.5": Case(SETTING._replace(student=SETTING.student.replace("trust=1.0", "trust=0.5"))),
    "students drawn": Case(SETTING._replace(vary=VARIED)),
    "bandits": Case(SETTINGS[1]._replace(budget=8)),
    "alpha 0.9": student(alpha=0.9),
    "40 rooms": rooms(40),
    "epsilon 0.3": Case(SETTING._replace(student=SETTING.student.replace("epsilon=0.1", "epsilon=0.3"))),
    "optimism 1": Case(SETTING._replace(student=SETTING.student.replace("optimism=0.0", "optimism=1.0"))),
    **{f"without {group}": Case(without=names) for group, names in GROUPS.items() if group != "way"},
}
"""The first are at the reference setting; each other one differs from `budget 8` in one thing."""


class Weighed:
    """Teachers that weigh what they see, in units of its deviation in play."""

    def __init__(self, case: Case) -> None:
        """With the numbers that this case shows."""
        self.setting = case.setting
        self.used = [number for number in USED if SEEN[number] not in case.without]
        seats = Seats(case.setting, range(FIRST - LIVES, FIRST), pool=1)
        rng, seen = np.random.default_rng(0), []
        for _ in range(10 * case.setting.turns):
            seen.append(seats.seen[seats.choosing][:, self.used])
            seats.step(rng.random(len(seats.choosing)) < LEAST)
        met = np.concatenate(seen)
        self.mean, self.deviation = met.mean(axis=0), np.maximum(met.std(axis=0), LEAST)

    def near(self, moves: int) -> np.ndarray:
        """The weights of the rule of nearness; who does not see the way corrects all mistakes."""
        weights = np.zeros(len(self.used) + 1)
        weights[-1] = STEEP
        if WAY in self.used:
            at = self.used.index(WAY)
            limit = (moves + 0.5) / (moves + 4.5)
            weights[at], weights[-1] = -STEEP, STEEP * (limit - self.mean[at]) / self.deviation[at]
        return weights

    def speaks(self, weights: np.ndarray, seen: np.ndarray) -> np.ndarray:
        """Whether teachers speak, bool (rows,), with weights (rows, k), or (k,) of one, that see this, (rows, 14)."""
        scaled = (seen[:, self.used] - self.mean) / self.deviation
        said: np.ndarray = (scaled * weights[..., :-1]).sum(axis=1) + weights[..., -1] > 0
        return said

    def live(self, weights: np.ndarray, firsts: Iterable[int], lifetimes: int) -> np.ndarray:
        """The student's regret per episode with each teacher, shape (teachers, lifetimes).

        Args:
            weights: of the teachers, shape (teachers, k).
            firsts: the first seed of the lifetimes of each.
            lifetimes: of each.
        """
        everyone = np.repeat(weights, lifetimes, axis=0)
        seeds = [first + i for first in firsts for i in range(lifetimes)]
        seats = Seats(self.setting, seeds, pool=1)
        return lived(seats, lambda seen, rows: self.speaks(everyone[rows], seen), self.setting).reshape(-1, lifetimes)


def trained(case: Case, seeds: Sequence[int], generations: int, lifetimes: int, moves: int) -> list[Line]:
    """Trainings from the rule of so many moves, side by side, and the regret of each lifetime with their teachers."""
    began = time.process_time()
    teachers = Weighed(case)
    settings = {"popsize": CANDIDATES, "verbose": -9}
    searches = [cma.CMAEvolutionStrategy(teachers.near(moves), SPREAD, settings | {"seed": seed + 1}) for seed in seeds]
    ends = {round(generations * (stage + 1) / STAGES) for stage in range(STAGES)} - {0}
    means, trials = [], []
    for generation in range(1, generations + 1):
        drawn = [search.ask() for search in searches]
        firsts = [FIRST + (seed * 1000 + generation) * LIVES for seed in seeds for _ in range(CANDIDATES)]
        regrets = teachers.live(np.concatenate(drawn), firsts, LIVES).mean(axis=1)
        for search, candidates, regret in zip(searches, drawn, regrets.reshape(-1, CANDIDATES), strict=True):
            search.tell(candidates, regret.tolist())
        if generation in ends:
            means.append(np.array([search.mean for search in searches]))
            trials.append(teachers.live(means[-1], [TRIAL] * len(seeds), lifetimes).mean(axis=1))
    spent = (time.process_time() - began) / len(seeds)
    chosen = np.array(means)[np.argmin(trials, axis=0), range(len(seeds))]
    regrets = teachers.live(np.concatenate([chosen, means[-1]]), [FRESH] * 2 * len(seeds), lifetimes)
    lines = []
    for i, seed in enumerate(seeds):
        line = {"seed": seed, "seconds": round(spent), "stage": int(np.argmin(trials, axis=0)[i]) + 1}
        line |= {"weights": chosen[i].round(2).tolist(), LEARNED: listed(regrets[i])}
        lines.append(line | {LAST: listed(regrets[len(seeds) + i])})
    return lines


def ruled(setting: Setting, lifetimes: int) -> Line:
    """Rules that see what the learned teacher sees; of nearness the one that is best on trial."""
    tried = range(1, 11)
    limits = np.repeat([moves / (moves + 4) for moves in tried], lifetimes)
    seats = Seats(setting, [*range(TRIAL, TRIAL + lifetimes)] * len(tried), pool=1)
    trials = lived(seats, lambda seen, rows: seen[:, WAY] <= limits[rows] + ROUNDING, setting)
    moves = tried[int(np.argmin(trials.reshape(-1, lifetimes).mean(axis=1)))]
    near = near_mistakes(moves=moves)

    def reached(seen: np.ndarray) -> np.ndarray:
        spent = np.rint(setting.budget * (1 - seen[:, SHARE]))
        farthest: np.ndarray = 2 + spent
        return seen[:, WAY] <= farthest / (farthest + 4) + ROUNDING

    rules: Mapping[str, Policy] = {
        ALL: near_mistakes(others=1.0),
        NEAR: near,
        ONCE: lambda seen: near(seen) & (seen[:, ADVISED] <= 0.2),  # 1 / (1 + 4)
        REACHED: reached,
    }
    return {"moves": moves} | {
        name: listed(accompanied(rule, setting, range(FRESH, FRESH + lifetimes))) for name, rule in rules.items()
    }


def listed(regrets: np.ndarray) -> list[float]:
    """As they are stored."""
    return [round(float(each), 2) for each in regrets]


def read(path: Path) -> list[Line]:
    """What there is."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def shown(estimate: Estimate) -> str:
    """In a cell."""
    return estimate.text()


def over_trainings(gains: np.ndarray) -> str:
    """Student's interval of the mean of a few trainings."""
    if len(gains) < 2:
        return ""
    low, high = stats.ttest_1samp(gains, 0).confidence_interval() if np.ptp(gains) else (gains[0], gains[0])
    return f"[{low:.2f}, {high:.2f}]"


def table(lines: Sequence[Line]) -> list[str]:
    """Per case what the student wastes by each teacher, and what the learned ones save.

    Of the mean of all trainings with intervals over lifetimes; then, beside the rule of nearness, over trainings.
    """
    rules = ALL, NEAR, ONCE, REACHED
    rows = [f"| case | {' | '.join(rules)} | {LEARNED} | {LAST} | less than {ALL} | than {NEAR} | by trainings | n |"]
    rows.append("|---" * (len(rules) + 7) + "|")
    for name in CASES:
        of_case = [line for line in lines if line["case"] == name]
        trainings = [line for line in of_case if LEARNED in line]
        if not trainings:
            continue
        given = next(line for line in of_case if ALL in line)
        wasted = [f"{np.mean(given[rule]):.2f}" for rule in rules]
        wasted[rules.index(NEAR)] += f" ({given['moves']})"
        lives = np.array([line[LEARNED] for line in trainings])
        last = np.mean([line[LAST] for line in trainings])
        cells = [name, *wasted, shown(mean_interval(lives.mean(axis=0))), f"{last:.2f}"]
        cells += [shown(mean_interval(given[rule] - lives.mean(axis=0))) for rule in (ALL, NEAR)]
        cells += [over_trainings((given[NEAR] - lives).mean(axis=1)), str(len(lives))]
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def draw(lines: Sequence[Line], path: str) -> None:
    """What each training saves beside the rule that it began with, and their mean with its interval over lifetimes."""
    from matplotlib.figure import Figure

    names = [name for name in CASES if any(line["case"] == name and LEARNED in line for line in lines)]
    figure = Figure(figsize=(8, 1 + 0.3 * len(names)), layout="constrained")
    axes = figure.subplots()
    for row, name in enumerate(reversed(names)):
        of_case = [line for line in lines if line["case"] == name]
        near = next(np.array(line[NEAR]) for line in of_case if NEAR in line)
        gains = near - np.array([line[LEARNED] for line in of_case if LEARNED in line])
        estimate = mean_interval(gains.mean(axis=0))
        axes.plot((estimate.low, estimate.high), (row, row), color="C0", linewidth=2)
        axes.plot(gains.mean(axis=1), [row] * len(gains), "o", color="C1", markersize=4, alpha=0.6)
        axes.plot(estimate.mean, row, "|", color="C0", markersize=12)
    axes.axvline(0, color="0.7", zorder=0)
    axes.set(yticks=range(len(names)), yticklabels=names[::-1], xlabel="regret per episode, less than near mistakes")
    figure.savefig(path, dpi=110)


def main() -> None:
    """Train what the file lacks; print what it has."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", default=[*CASES], choices=CASES, metavar="CASE", help=", ".join(CASES))
    parser.add_argument("--trainings", type=int, default=10, help="of a case, at most; 10 by budget, 3 of others")
    parser.add_argument("--generations", type=int, help="in place of what the cases say, to try it out")
    parser.add_argument("--lifetimes", type=int, default=300, help="to compare on, and to choose on")
    parser.add_argument("--store", type=Path, required=True, help="file of JSON lines")
    parser.add_argument("--plot", help="file for the figure")
    arguments = parser.parse_args()
    there = read(arguments.store)
    for first in range(0, arguments.trainings, TOGETHER):
        for name in arguments.cases:
            case, done = CASES[name], [line for line in there if line["case"] == name]
            lines = [] if done else [ruled(case.setting, arguments.lifetimes)]
            last = min(first + TOGETHER, arguments.trainings, case.trainings)
            if seeds := [seed for seed in range(first, last) if seed not in [line.get("seed") for line in done]]:
                moves = next(line["moves"] for line in [*done, *lines] if "moves" in line)
                lines += trained(case, seeds, arguments.generations or case.generations, arguments.lifetimes, moves)
            lines = [{"case": name} | line for line in lines]
            with arguments.store.open("a", encoding="utf-8") as file:
                file.writelines(f"{json.dumps(line)}\n" for line in lines)
            there += lines
    print("\n".join(table(there)))
    if arguments.plot:
        draw(there, arguments.plot)


if __name__ == "__main__":
    main()
