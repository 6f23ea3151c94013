"""Teachers that learn when to advise (Zimmer et al. 2014, Fachantidis et al. 2019), beside rules that see the same."""

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

from llf_teacher.reproductions.advisers import ROUNDS, ROWS, Choices, Pay, Policy, lived, trained
from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.row import FIRST_SEED, Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference
from worlds.batches import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ID, EPISODES, TURNS, FAR, GAMMA = "llf-gridworld-v0", 30, 40, 6, 0.95
NEAR = {2: 2, 4: 3, 8: 4, 16: 6, 32: 8}
"""By budget, the distance to the treasure within which the rule `near mistakes` corrects."""
TRAININGS, SEEDS, LIFETIMES, FRESH = 3, 20, 10, 3_000_000
"""Trainings of a teacher; seeds, lifetimes per seed, and the first seed of lifetimes."""


def _value(choices: Choices) -> Floats:
    """Difference of the discounted values of the best and the worst action."""
    return GAMMA ** (choices.way - 1) * (1 - GAMMA**choices.importance)


PAID: dict[str, Pay] = {"Zimmer": None, "Fachantidis": _value}
RULES: dict[str, Policy] = {
    "announced mistake": lambda choices: choices.way >= 0,
    "important mistakes": lambda choices: choices.importance >= 2,
}
NEARBY = "near mistakes"
TEACHERS = (*RULES, NEARBY, *PAID)


@cache
def _found(who: str, budget: int, near: int, episodes: int) -> list[Floats]:
    """Regret per episode of all lifetimes, after each training; cached for all seeds of a process."""
    terms = {"episodes": episodes, "turns": TURNS, "budget": budget, "min_goal_dist": FAR}
    if who in PAID:
        policies = [trained(ID, PAID[who], number, **terms) for number in range(TRAININGS)]
    else:
        policies = [RULES.get(who, lambda choices: choices.way <= near)]
    found = [lived(policy, ID, range(FRESH, FRESH + SEEDS * LIFETIMES), **terms) for policy in policies]
    return found * (TRAININGS // len(found))


def measure(who: str, budget: int, near: int, seed: int) -> Sequence[float]:
    """Regret per episode, after each training; equal for a rule, which has no training."""
    first = (seed - FIRST_SEED) * LIFETIMES
    return [float(regrets[first : first + LIFETIMES].mean()) for regrets in _found(who, budget, near, EPISODES)]


def _setting(teacher: str, budget: int) -> dict[str, str | int]:
    return {"who": teacher, "budget": budget, "near": NEAR[budget]}


def _regret(values: Values, teacher: str, budget: int) -> Floats:
    """Mean over trainings, per seed."""
    regret: Floats = values(**_setting(teacher, budget)).mean(axis=1)
    return regret


def _less(values: Values, budget: int, teacher: str, than: str) -> Estimate:
    """How much less regret a teacher gives than another."""
    return paired_difference(_regret(values, than, budget), _regret(values, teacher, budget)).estimate


def read(values: Values) -> Reading:
    """Learned teachers beside rules."""
    table = [
        ["budget", "teacher", "regret per episode", *(f"less than {rule}" for rule in (*RULES, NEARBY)), "trainings"]
    ]
    for budget in NEAR:
        for teacher in TEACHERS:
            gains = [describe(_less(values, budget, teacher, rule)) for rule in (*RULES, NEARBY)]
            single = [f"{mean:.2f}" for mean in values(**_setting(teacher, budget)).mean(axis=0)]
            regret = describe(mean_interval(_regret(values, teacher, budget)))
            table.append([str(budget), teacher, regret, *gains, ", ".join(single) if teacher in PAID else ""])
    parts, wins = list[str](), list[int]()
    for teacher in PAID:
        beside = {rule: [_less(values, budget, teacher, rule) for budget in NEAR] for rule in (*RULES, NEARBY)}
        above = {rule: sum(each.low > 0 for each in found) for rule, found in beside.items()}
        below = {rule: sum(each.high < 0 for each in found) for rule, found in beside.items()}
        wins.append(above[next(iter(RULES))])
        counts = ", ".join(f"{rule} at {above[rule]} and worse at {below[rule]}" for rule in beside)
        saved = ", ".join(describe(each) for each in beside[next(iter(RULES))])
        parts.append(
            f"With {SAID[teacher]} as its reward, a teacher is significantly better than {counts} of {len(NEAR)} "
            f"budgets; beside announced mistake it saves {saved} moves an episode with budgets of "
            f"{', '.join(map(str, NEAR))}."
        )
    agrees = "yes" if min(wins) == len(NEAR) else "in part" if max(wins) else "no"
    why = (
        "If the budget is enough for nearly all mistakes, there is no choice. Near mistakes is a rule with a number "
        "that was chosen for each budget. Progress measures the effect of advice on later episodes; the worth of the "
        "present action does not, but grows towards the treasure, where advice has the greatest effect. The papers "
        "learn online, by Q-learning, and in other worlds. Online Q-learning over tiles was tried first and was worse "
        "than announced mistake; so both are fitted by least squares here, which compares their rewards and not the "
        "speed of their learners."
    )
    return Reading(agrees, " ".join(parts), why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret, one group of bars per budget."""
    axes = figure.subplots()
    found = {teacher: [mean_interval(_regret(values, teacher, budget)) for budget in NEAR] for teacher in TEACHERS}
    bars(axes, [str(budget) for budget in NEAR], found)
    axes.set(xlabel="budget", ylabel="regret per episode")
    figure.legend(loc="outside right center", fontsize="small")


SAID = {"Zimmer": "progress (Zimmer)", "Fachantidis": "the worth of actions (Fachantidis)"}
ROW = Row(
    claim="A teacher that learns when to advise beats rules at an equal budget",
    source="Zimmer et al. 2014, Fachantidis et al. 2019",
    protocol=(
        f"The setting of a teacher that learned (learn-to-teach.md), and its 200 lifetimes: houses of 20 rooms, the "
        f"treasure at least {FAR} moves away, {EPISODES} episodes of at most {TURNS} moves from the same room. The "
        "student is Q-learning, announces what it means to do, and takes the advised action for the turn. A decision "
        "is whether to correct a mistake that is announced. Zimmer's teacher is paid by the student's reward, here by "
        "its progress; Fachantidis' by what lies between the best and the worst action in discounted values "
        f"(discount {GAMMA}) where it advises. Both learn alike, in {ROUNDS} rounds of {ROWS} lifetimes: what "
        "correcting gains until the end of the lifetime is fitted by least squares, linear in the way to the treasure, "
        "the episode, the budget that is left, and their products. The rules see as much: announced mistake corrects "
        "all mistakes, important mistakes those with 2 moves at stake, near mistakes those near the treasure, within a "
        f"number of moves that was chosen by budget on other lifetimes. Figures are the mean of {TRAININGS} trainings; "
        f"a seed is {LIFETIMES} lifetimes."
    ),
    settings=tuple(_setting(teacher, budget) for budget in NEAR for teacher in TEACHERS),
    seeds=SEEDS,
    measure=measure,
    measures=tuple(f"regret per episode, training {number + 1}" for number in range(TRAININGS)),
    read=read,
    draw=draw,
)
