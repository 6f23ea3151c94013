"""Silence as information: I-SABL learns from less feedback (Loftin et al. 2014)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRAINERS = {
    "says both": (0.1, 0.1),
    "praises": (0.1, 0.9),
    "blames": (0.9, 0.1),
    "says little": (0.9, 0.9),
}
"""Probabilities of silence on right and on wrong actions."""
LEARNERS = {
    "I-SABL": "sabl(infers=True, forget=False)",
    "SABL, told the strategy": "sabl(plus={plus}, minus={minus}, forget=False)",
    "silence unheard": "sabl(plus=0.5, minus=0.5, forget=False)",
    "TAMER": "tamer(forget=False)",
}
EPISODES = 25


def measure(student: str, plus: float, minus: float, seed: int) -> Sequence[float]:
    """Regret per episode, and the number of labels before the episodes without regret."""
    teacher = f"only(kinds='hp+hn') | inactive(plus={plus}, minus={minus})"
    *regrets, _ = live("llf-gridworld-v0", student=student, teacher=teacher, episodes=EPISODES, turns=40, seed=seed)
    learned = next((i for i in range(EPISODES) if not any(regrets[i:])), EPISODES)
    needed = 0.0
    if learned:
        *_, needed = live("llf-gridworld-v0", student=student, teacher=teacher, episodes=learned, turns=40, seed=seed)
    return [float(np.mean(regrets)), needed]


def _setting(learner: str, trainer: str) -> dict[str, str | float]:
    plus, minus = TRAINERS[trainer]
    return {"student": LEARNERS[learner].format(plus=plus, minus=minus), "plus": plus, "minus": minus}


def read(values: Values) -> Reading:
    """Regret of I-SABL and the labels that it needs, beside learners that ignore silence."""
    table = [["trainer", "learner", "regret per episode", "labels until it is learned"]]
    for trainer in TRAINERS:
        for learner in LEARNERS:
            regret, labels = values(**_setting(learner, trainer)).T
            table.append([trainer, learner, describe(mean_interval(regret)), describe(mean_interval(labels), 1)])
    fewer, less = [], []
    for trainer in TRAINERS:
        hears, deaf = (values(**_setting(learner, trainer)) for learner in ("I-SABL", "silence unheard"))
        less.append(paired_difference(deaf[:, 0], hears[:, 0]).estimate)
        fewer.append(paired_difference(deaf[:, 1], hears[:, 1]).estimate)
    blames = list(TRAINERS).index("blames")
    ours = (
        f"With a trainer that blames and seldom praises, I-SABL has {describe(less[blames])} moves an episode less "
        f"regret and needs {describe(fewer[blames], 1)} labels less than the same learner that ignores silence; its "
        f"regret is significantly less with {sum(each.low > 0 for each in less)} of {len(TRAINERS)} trainers, and "
        f"significantly more with {sum(each.high < 0 for each in less)}."
    )
    agrees = "yes" if all(each.low > 0 for each in (less[blames], fewer[blames])) else "in part"
    if not any(each.low > 0 for each in (*less, *fewer)):
        agrees = "no"
    why = (
        "The papers find the strategy by expectation maximisation, ours sums its posterior over a grid. If a trainer "
        "is seldom silent, silence adds little."
    )
    return Reading(agrees, ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret and labels, by trainer."""
    panels = figure.subplots(1, 2)
    for column, (axes, title) in enumerate(zip(panels, ("regret per episode", "labels until learned"), strict=True)):
        found = {
            learner: [mean_interval(values(**_setting(learner, trainer))[:, column]) for trainer in TRAINERS]
            for learner in LEARNERS
        }
        bars(axes, list(TRAINERS), found)
        axes.set_title(title)
    panels[0].legend()


ROW = Row(
    claim="Silence is information: a learner that infers when a trainer is silent needs fewer labels",
    source="Loftin et al. 2014",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most 40 moves from the same room. Trainers know the right "
        "actions, and are silent on right and on wrong ones with probabilities (0.1, 0.1), (0.1, 0.9), (0.9, 0.1) and "
        "(0.9, 0.9). I-SABL infers these, SABL has them as parameters, *silence unheard* is SABL with equal ones, so "
        "that silence means nothing. A learner has learned when it plays without regret until the end. The papers have "
        "a contextual bandit, a maze and people as trainers."
    ),
    settings=tuple(_setting(learner, trainer) for trainer in TRAINERS for learner in LEARNERS),
    seeds=40,
    measure=measure,
    measures=("regret per episode", "labels until it is learned"),
    read=read,
    draw=draw,
)
