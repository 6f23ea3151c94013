"""Advise with labels that are rare or often wrong (Griffith et al. 2013)."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.drawing import line, name_lines
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIKELIHOOD = (0.1, 0.5, 1.0)
CONSISTENCY = (0.55, 0.7, 0.85, 1.0)
ALONE = "q_learning(forget=False)"
"""Learns from rewards only: greedily from optimistic values, which wastes less than Advise does without labels."""
SURE = 0.99
"""What Advise is told of labels that are always right; it cannot be told 1."""
LEARNERS = {
    "Advise, told the consistency": "advise(forget=False, consistency={told})",
    "Advise, told 0.8": "advise(forget=False, consistency=0.8)",
    "Advise, optimistic": "advise(forget=False, consistency={told}, optimism=1.0, temperature=0.005)",
    "TAMER": "tamer(forget=False)",
}
TOLD = next(iter(LEARNERS))
"""The paper's Advise: its model of the trainer is right."""
NEVER = {"student": ALONE, "likelihood": 0.0, "consistency": 1.0}
DEAF = {"student": "advise(forget=False, consistency=0.5)", "likelihood": 0.0, "consistency": 1.0}
"""Advise without labels, which the table has beside the others."""
REGRET = "regret per episode"
EXPECTED = {"rare": (0.1, 1.0), "often wrong": (1.0, 0.55)}
"""Likelihood and consistency of the labels that the claim is about; both are the paper's."""


def _setting(learner: str, likelihood: float, consistency: float) -> dict[str, str | float]:
    student = LEARNERS[learner].format(told=min(consistency, SURE))
    return {"student": student, "likelihood": likelihood, "consistency": consistency}


def measure(student: str, likelihood: float, consistency: float, seed: int) -> Sequence[float]:
    """Regret per episode of a lifetime."""
    teacher = f"only(kinds='hp+hn') | inconsistent(likelihood={likelihood}, consistency={consistency})"
    regrets = live("llf-gridworld-v0", student=student, teacher=teacher, episodes=40, turns=40, seed=seed)
    return [float(np.mean(regrets[:-1]))]


def read(values: Values) -> Reading:
    """How much less regret labels give than rewards alone."""
    alone = values(**NEVER)[:, 0]
    heads = ["learner", "likelihood", *(f"consistency {c:g}" for c in CONSISTENCY)]
    table, gains = [heads], {}
    for name in LEARNERS:
        for likelihood in LIKELIHOOD:
            cells = []
            for consistency in CONSISTENCY:
                found = values(**_setting(name, likelihood, consistency))[:, 0]
                gain = gains[name, likelihood, consistency] = paired_difference(alone, found).estimate
                cells.append(describe(gain, 1))
            table.append([name, f"{likelihood:g}", *cells])
    deaf = values.means(**DEAF)[0]
    rare, poor = (gains[TOLD, *cell] for cell in EXPECTED.values())
    same = [gains["Advise, optimistic", *cell] for cell in EXPECTED.values()]
    trusting = gains["Advise, told 0.8", *EXPECTED["often wrong"]]
    ours = (
        f"From rewards alone greedy Q-learning wastes {describe(mean_interval(alone), 1)} moves an episode, and Advise "
        f"without labels {describe(deaf, 1)}. Beside greedy Q-learning Advise saves {describe(rare, 1)} with a tenth "
        f"of right labels, and {describe(poor, 1)} with labels of which 55 % are right; {describe(trusting, 1)} if it "
        "takes these to be right in 80 %. If its exploration is that of greedy Q-learning, too, it saves "
        f"{describe(same[0], 1)} and {describe(same[1], 1)}."
    )
    why = (
        "Advise is compared with the best learner from rewards that is here, and not with itself without labels, whose "
        "Boltzmann exploration wastes more: a gain beside that one may be due to any reason to act otherwise. A label "
        "that is right in 55 % says little of an action, and a house has 80 of them. Labels help most where "
        "exploration from rewards is poor, and greedy learning from optimistic values explores a house well."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by consistency, one panel per likelihood."""
    alone = values(**NEVER)[:, 0].mean()
    panels = figure.subplots(1, len(LIKELIHOOD), sharey=True)
    for axes, likelihood in zip(panels, LIKELIHOOD, strict=True):
        for name in LEARNERS:
            found = [values.means(**_setting(name, likelihood, c))[0] for c in CONSISTENCY]
            line(axes, CONSISTENCY, found, name)
        ends = CONSISTENCY[0], CONSISTENCY[-1]
        axes.plot(ends, [alone, alone], color="gray", linestyle="--", marker="", label="rewards alone")
        axes.set(title=f"a label in {likelihood:.0%} of turns", xlabel="share of right labels")
    panels[0].set_ylabel("regret per episode")
    name_lines(figure)


ROW = Row(
    claim="Policy shaping (Advise) learns from labels that are rare or often wrong, better than from rewards alone",
    source="Griffith et al. 2013",
    protocol=(
        "Houses of 20 rooms, 40 episodes of at most 40 moves, always from the same room. The teacher labels the last "
        "move right or wrong with probability *likelihood*, and truly with probability *consistency*. Advise "
        "(Q-learning with Boltzmann exploration) is told the consistency, as its model of the trainer assumes; beside "
        "it are Advise that always assumes 0.8, Advise that is nearly greedy on optimistic values, and TAMER, which "
        "believes labels and hears no rewards. All are compared with Q-learning from rewards alone, greedy on "
        "optimistic values. The paper has Pac-Man and Frogger and Bayesian Q-learning. Cells are moves saved per "
        "episode against rewards alone, paired by seed."
    ),
    settings=(
        NEVER,
        DEAF,
        *(_setting(*cell) for cell in product(LEARNERS, LIKELIHOOD, CONSISTENCY)),
    ),
    rule=Rule(
        seeds=30,
        comparisons=tuple(
            saves(
                f"Advise wastes less than rewards alone, with labels that are {cell}",
                _setting(TOLD, *shares),
                NEVER,
                REGRET,
            )
            for cell, shares in EXPECTED.items()
        ),
    ),
    measure=measure,
    measures=(REGRET,),
    read=read,
    draw=draw,
)
