"""Advise with labels that are rare or often wrong (Griffith et al. 2013)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.drawing import line
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LIKELIHOOD = (0.1, 0.5, 1.0)
CONSISTENCY = (0.55, 0.7, 0.85, 1.0)
ALONE = "advise(consistency=0.5, forget=False)"
"""Ignores labels, so that it learns from rewards only."""
LEARNERS = {"advise": "advise(consistency=0.8, forget=False)", "tamer": "tamer(forget=False)"}
NEVER = {"student": ALONE, "likelihood": 0.0, "consistency": 1.0}


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
    for name, student in LEARNERS.items():
        for likelihood in LIKELIHOOD:
            cells = []
            for consistency in CONSISTENCY:
                found = values(student=student, likelihood=likelihood, consistency=consistency)[:, 0]
                gain = gains[name, likelihood, consistency] = paired_difference(alone, found).estimate
                cells.append(describe(gain, 1))
            table.append([name, f"{likelihood:g}", *cells])
    harmed = {name: [gain for (who, *_), gain in gains.items() if who == name and gain.high < 0] for name in LEARNERS}
    helped = [gain for (who, *_), gain in gains.items() if who == "advise" and gain.low > 0]
    rare, poor = gains["advise", 0.1, 1.0], gains["advise", 1.0, 0.55]
    ours = (
        f"From rewards alone the regret is {describe(mean_interval(alone), 1)} moves an episode. Advise gains "
        f"{describe(rare, 1)} of it from a tenth of right labels, and {describe(poor, 1)} from labels of which 55 % "
        f"are right; it is significantly better than rewards alone in {len(helped)} of "
        f"{len(LIKELIHOOD) * len(CONSISTENCY)} cells and significantly worse in {len(harmed['advise'])}; TAMER is "
        f"significantly worse in {len(harmed['tamer'])}."
    )
    if harmed["advise"]:
        why = "Advise believes labels with C = 0.8; where they are right less often, it trusts them too much."
    else:
        why = ""
    agrees = "no" if not rare.low > 0 else "in part" if harmed["advise"] else "yes"
    return Reading(agrees, ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by consistency, one panel per likelihood."""
    alone = values(**NEVER)[:, 0].mean()
    panels = figure.subplots(1, len(LIKELIHOOD), sharey=True)
    for axes, likelihood in zip(panels, LIKELIHOOD, strict=True):
        for name, student in LEARNERS.items():
            found = [
                mean_interval(values(student=student, likelihood=likelihood, consistency=c)[:, 0]) for c in CONSISTENCY
            ]
            line(axes, CONSISTENCY, found, name)
        axes.axhline(alone, color="gray", linestyle="--", label="rewards alone")
        axes.set(title=f"a label in {likelihood:.0%} of turns", xlabel="share of right labels")
    panels[0].set_ylabel("regret per episode")
    panels[0].legend()


ROW = Row(
    claim="Policy shaping (Advise) learns from labels that are rare or often wrong, better than from rewards alone",
    source="Griffith et al. 2013",
    protocol=(
        "Houses of 20 rooms, 40 episodes of at most 40 moves, always from the same room. The teacher labels the last "
        "move right or wrong with probability *likelihood*, and truly with probability *consistency*. Advise (C = "
        "0.8, Q-learning with Boltzmann exploration) is compared with itself without labels, and with TAMER, which "
        "believes labels and hears no rewards. The paper has Pac-Man and Frogger and Bayesian Q-learning. "
        "Cells are moves saved per episode against rewards alone, paired by seed."
    ),
    settings=(
        NEVER,
        *(
            {"student": student, "likelihood": likelihood, "consistency": consistency}
            for student in LEARNERS.values()
            for likelihood in LIKELIHOOD
            for consistency in CONSISTENCY
        ),
    ),
    seeds=30,
    measure=measure,
    measures=("regret per episode",),
    read=read,
    draw=draw,
)
