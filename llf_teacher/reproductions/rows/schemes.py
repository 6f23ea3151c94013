"""COACH and E-COACH with feedback on policies, rewards and advantages (MacGlashan et al. 2017, Shah et al. 2021)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import TENTH, Expectation, Rule, saves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMES = {
    "policy": ("only(kinds='hp+hn')", "verdicts"),
    "advantage": ("policy_dependent | only(kinds='hp+hn')", "verdicts"),
    "reward": ("only(kinds='r')", "rewards"),
}
"""By the content of labels, the personality and the learner's reading of them."""
LEARNERS = {
    "COACH": "coach(forget=False, listens='{listens}')",
    "COACH without a trace": "coach(forget=False, listens='{listens}', trace=0.0)",
    "E-COACH": "coach(forget=False, listens='{listens}', episodic=True, alpha=0.1)",
    "TAMER": "tamer(forget=False)",
    "Q-learning": "q_learning(forget=False, optimism=0.0, epsilon=0.1)",
}
EPISODES, TURNS, LAST, ROOMS = 400, 40, 20, 10
LEAST = 1 - TENTH
"""Share of the regret of an untaught learner that one has lost that has learned."""
REGRET = f"regret per episode, last {LAST}"


def measure(student: str, teacher: str, episodes: int, seed: int) -> Sequence[float]:
    """Mean regret of the last episodes, and of all."""
    regrets = live(
        "llf-gridworld-v0",
        student=student,
        teacher=teacher,
        episodes=episodes,
        turns=TURNS,
        seed=seed,
        num_rooms=ROOMS,
        min_goal_dist=3,
    )[:-1]
    return [float(np.mean(regrets[-LAST:])), float(np.mean(regrets))]


def _setting(learner: str, scheme: str) -> dict[str, str | int]:
    teacher, listens = SCHEMES[scheme]
    return {"student": LEARNERS[learner].format(listens=listens), "teacher": teacher, "episodes": EPISODES}


UNTAUGHT = _setting("E-COACH", "policy") | {"teacher": "silent"}


def read(values: Values) -> Reading:
    """Regret at the end, per learner and scheme."""
    table = [["learner", *(f"{scheme} feedback" for scheme in SCHEMES)]]
    last = {}
    for learner in LEARNERS:
        for scheme in SCHEMES:
            last[learner, scheme] = values.means(**_setting(learner, scheme))[0]
        table.append([learner, *(describe(last[learner, scheme]) for scheme in SCHEMES)])
    ours = (
        f"At the end E-COACH wastes {', '.join(describe(last['E-COACH', scheme]) for scheme in SCHEMES)} moves an "
        f"episode under {', '.join(SCHEMES)} feedback, COACH "
        f"{', '.join(describe(last['COACH', scheme]) for scheme in SCHEMES)}, and E-COACH without feedback "
        f"{describe(values.means(**UNTAUGHT)[0])}."
    )
    why = (
        "The paper proves that E-COACH converges under each kind of feedback, and that there are worlds in which COACH "
        "does not; a house in which COACH learns is no argument against that. The guarantee costs time: E-COACH "
        "learns when an episode ends, in small steps (0.1; with 0.5 it converges to poor policies), and a label counts "
        "for every move before it. From rewards COACH needs its trace: without one it learns the last move only."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret at the end, one group of bars per scheme."""
    axes = figure.subplots()
    found = {learner: [values.means(**_setting(learner, scheme))[0] for scheme in SCHEMES] for learner in LEARNERS}
    bars(axes, [f"{scheme} feedback" for scheme in SCHEMES], found)
    axes.set_ylabel(f"regret per episode, last {LAST}")
    axes.legend()


ROW = Row(
    claim="COACH can stay suboptimal under some kinds of labels, E-COACH learns from policies, rewards and advantages",
    source="MacGlashan et al. 2017, Shah et al. 2021",
    protocol=(
        f"Houses of {ROOMS} rooms with the treasure at least 3 moves away, {EPISODES} episodes of at most {TURNS} "
        "moves from the same room. A label says whether the move was right (policy), whether it was better or worse "
        "than the student's habit (advantage, the personality `policy_dependent`), or what it was paid (reward: 1 at "
        f"the treasure, else 0). Figures are moves wasted in each of the last {LAST} episodes. TAMER hears verdicts "
        "only, and nothing of rewards; Q-learning always learns from rewards and hears no labels. The paper has "
        "proofs and gridworlds of its own."
    ),
    rule=Rule(
        seeds=16,
        comparisons=(
            *(
                saves(
                    f"E-COACH learns from {scheme} feedback: it wastes at most a tenth of what it wastes without",
                    _setting("E-COACH", scheme),
                    UNTAUGHT,
                    REGRET,
                    LEAST,
                )
                for scheme in SCHEMES
            ),
            *(
                Expectation(
                    expects=f"COACH stays behind it under {scheme} feedback, by a tenth of the waste without",
                    more=(_setting("COACH", scheme),),
                    less=(_setting("E-COACH", scheme),),
                    measure=REGRET,
                    least=TENTH,
                    share_of=UNTAUGHT,
                )
                for scheme in SCHEMES
            ),
        ),
    ),
    settings=(UNTAUGHT, *(_setting(learner, scheme) for learner in LEARNERS for scheme in SCHEMES)),
    measure=measure,
    measures=(REGRET, "regret per episode"),
    read=read,
    draw=draw,
)
