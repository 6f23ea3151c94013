"""Silence as information: I-SABL learns from less feedback (Loftin et al. 2014)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import TENTH, Rule, saves
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
TELLING = ("praises", "blames")
"""The trainers whose silence has a meaning: it is more probable on one kind of action than on the other."""
LEARNERS = {
    "I-SABL": "sabl(infers=True, forget=False)",
    "SABL, told the strategy": "sabl(plus={plus}, minus={minus}, forget=False)",
    "silence unheard": "sabl(plus=0.5, minus=0.5, forget=False)",
    "TAMER": "tamer(forget=False)",
}
DEAF = "silence unheard"
EPISODES = 25
REGRET, LABELS = MEASURES = "regret per episode", "labels until it is learned"


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
    saved = []
    for trainer in TRAINERS:
        hears, deaf = (values(**_setting(learner, trainer)) for learner in ("I-SABL", DEAF))
        regret, labels = (paired_difference(deaf[:, column], hears[:, column]).estimate for column in range(2))
        saved.append(f"{describe(labels, 1)} labels and {describe(regret)} moves an episode ({trainer})")
    ours = f"Beside the same learner that ignores silence, I-SABL saves {'; '.join(saved)}."
    why = (
        "A trainer that praises is seldom silent on right actions: its first praise names one also to a learner that "
        "ignores silence, and few labels are left to save. A trainer that is as silent on right as on wrong actions "
        "says nothing by its silence, so that to infer its strategy can only cost labels: there the rule asks that it "
        "costs less than a tenth. The papers find the strategy by expectation maximisation, ours sums its posterior "
        "over a grid."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret and labels, by trainer."""
    panels = figure.subplots(1, 2)
    for column, (axes, title) in enumerate(zip(panels, ("regret per episode", "labels until learned"), strict=True)):
        found = {
            learner: [values.means(**_setting(learner, trainer))[column] for trainer in TRAINERS]
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
    rule=Rule(
        seeds=60,
        comparisons=tuple(
            saves(
                f"I-SABL needs fewer labels of a trainer that {trainer}"
                if trainer in TELLING
                else f"I-SABL needs hardly more labels of a trainer that {trainer}",
                _setting("I-SABL", trainer),
                _setting(DEAF, trainer),
                LABELS,
                TENTH if trainer in TELLING else -TENTH,
            )
            for trainer in TRAINERS
        ),
    ),
    settings=tuple(_setting(learner, trainer) for trainer in TRAINERS for learner in LEARNERS),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
