"""Teachers that learn when to advise (Zimmer et al. 2014, Fachantidis et al. 2019), beside rules that see the same."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from llf_teacher.reproductions.advisers import ROUNDS, ROWS, Choices, Pay, Policy, lived, trained
from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference
from worlds.batches import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ID, EPISODES, TURNS, FAR, GAMMA = "llf-gridworld-v0", 30, 40, 6, 0.95
NEAR = {8: 4}
"""By budget, the distance to the treasure within which the rule `near mistakes` corrects."""
LIFETIMES = 40
"""Lifetimes in which the teacher of a seed is tested; no training has one of them."""
REGRET = "regret per episode"


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


def measure(who: str, budget: int, near: int, seed: int) -> Sequence[float]:
    """Mean regret per episode in the lifetimes of a seed; a teacher that learns has a training of its own."""
    terms = {"episodes": EPISODES, "turns": TURNS, "budget": budget, "min_goal_dist": FAR}
    if who in PAID:
        policy = trained(ID, PAID[who], seed, **terms)
    else:
        policy = RULES.get(who, lambda choices: choices.way <= near)
    return [float(lived(policy, ID, range(seed * LIFETIMES, (seed + 1) * LIFETIMES), **terms).mean())]


def _setting(teacher: str, budget: int) -> dict[str, str | int]:
    return {"who": teacher, "budget": budget, "near": NEAR[budget]}


def _regret(values: Values, teacher: str, budget: int) -> Floats:
    regret: Floats = values(**_setting(teacher, budget))[:, 0]
    return regret


def _less(values: Values, budget: int, teacher: str, than: str) -> Estimate:
    """How much less regret a teacher gives than another."""
    return paired_difference(_regret(values, than, budget), _regret(values, teacher, budget)).estimate


def read(values: Values) -> Reading:
    """Learned teachers beside rules."""
    table = [["budget", "teacher", REGRET, *(f"less than {rule}" for rule in (*RULES, NEARBY))]]
    for budget in NEAR:
        for teacher in TEACHERS:
            gains = [describe(_less(values, budget, teacher, rule)) for rule in (*RULES, NEARBY)]
            regret = describe(mean_interval(_regret(values, teacher, budget)))
            table.append([str(budget), teacher, regret, *gains])
    parts = list[str]()
    for teacher in PAID:
        saved = "; ".join(
            f"{', '.join(describe(_less(values, budget, teacher, rule)) for budget in NEAR)} beside {rule}"
            for rule in (*RULES, NEARBY)
        )
        parts.append(
            f"With {SAID[teacher]} as its reward and {' and '.join(map(str, NEAR))} pieces of advice, a teacher saves "
            f"this many moves an episode: {saved}."
        )
    why = (
        "The learned teachers see as much as near mistakes does, a rule with a number that was chosen for the budget, "
        "and do not find it. Progress measures the effect of advice on later episodes; the worth of the "
        "present action does not, but grows towards the treasure, where advice has the greatest effect. The papers "
        "learn online, by Q-learning, and in other worlds. Online Q-learning over tiles was tried first and was worse "
        "than announced mistake; so both are fitted by least squares here, which compares their rewards and not the "
        "speed of their learners."
    )
    return Reading(" ".join(parts), why, table)


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
        f"The setting of a teacher that learned (learn-to-teach.md), in other lifetimes: houses of 20 rooms, the "
        f"treasure at least {FAR} moves away, {EPISODES} episodes of at most {TURNS} moves from the same room, and "
        f"{' or '.join(map(str, NEAR))} pieces of advice in all. The "
        "student is Q-learning, announces what it means to do, and takes the advised action for the turn. A decision "
        "is whether to correct a mistake that is announced. Zimmer's teacher is paid by the student's reward, here by "
        "its progress; Fachantidis' by what lies between the best and the worst action in discounted values "
        f"(discount {GAMMA}) where it advises. Both learn alike, in {ROUNDS} rounds of {ROWS} lifetimes: what "
        "correcting gains until the end of the lifetime is fitted by least squares, linear in the way to the treasure, "
        "the episode, the budget that is left, and their products. The rules see as much: announced mistake corrects "
        "all mistakes, important mistakes those with 2 moves at stake, near mistakes those near the treasure, within a "
        f"number of moves that was chosen by budget on other lifetimes. A seed is a training and {LIFETIMES} "
        "lifetimes in which it is tested, as the rules are."
    ),
    settings=tuple(_setting(teacher, budget) for budget in NEAR for teacher in TEACHERS),
    rule=Rule(
        seeds=8,
        comparisons=tuple(
            saves(
                f"{teacher}'s teacher wastes less than {rule}, with {budget} pieces",
                _setting(teacher, budget),
                _setting(rule, budget),
                REGRET,
            )
            for teacher in PAID
            for rule in (*RULES, NEARBY)
            for budget in NEAR
        ),
    ),
    measure=measure,
    measures=(REGRET,),
    read=read,
    draw=draw,
)
