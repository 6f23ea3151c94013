"""Choosing a single claim beside choosing a kind, at equal numbers of claims (Goldman & Kearns 1995)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.reproductions.drawing import line
from llf_teacher.reproductions.reviews import commented
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EPISODES, TURNS, BUDGETS = 20, 40, (5, 10, 20, 40)
LEARNERS = {
    "obedient, advice": ("obedient(forget=False)", "fp"),
    "text_only, verdicts": ("text_only(forget=False)", "hp+hn"),
    "SABL, verdicts": ("sabl(forget=False)", "hp+hn"),
    "Advise, verdicts": ("advise(forget=False)", "hp+hn"),
}
"""The learner and its kinds of claims."""
CLAIM = "the very claim"
REVIEWS = {
    "all of a kind": ("end_of_episode(top_k=32)", "kinds"),
    "three of a kind": ("end_of_episode(top_k=3)", "kinds"),
    "one of a kind": ("end_of_episode(top_k=1)", "kinds"),
    CLAIM: ("end_of_episode(top_k=32)", "claims"),
}
"""A teacher's choice after an episode: the personality that offers claims, and the form of speech."""
AT_ONCE = {"at once, the kind": ("oracle", "kinds"), "at once, the very claim": ("oracle", "claims")}


def measure(student: str, feedback: str, teacher: str, speech: str, budget: int, seed: int) -> Sequence[float]:
    """Moves wasted per episode, and the number of claims."""
    return commented(
        "llf-gridworld-v0",
        student=student,
        feedback=feedback,
        teacher=teacher,
        speech=speech,
        budget=budget,
        seed=seed,
        episodes=EPISODES,
        turns=TURNS,
    )


def _setting(learner: str, choice: str, budget: int) -> dict[str, Any]:
    (student, feedback), (teacher, speech) = LEARNERS[learner], (REVIEWS | AT_ONCE)[choice]
    return {"student": student, "feedback": feedback, "teacher": teacher, "speech": speech, "budget": budget}


def _lost(values: Values, learner: str, choice: str, budget: int) -> NDArray[np.float64]:
    return values(**_setting(learner, choice, budget))[:, 0]


def read(values: Values) -> Reading:
    """Regret by budget, and where choosing claims is significantly better than the best way to choose kinds."""
    table = [["learner", "the teacher chooses", *(f"{budget} claims" for budget in BUDGETS)]]
    better, worse, moved = [], [], 0.0
    for learner in LEARNERS:
        for choice in REVIEWS | AT_ONCE:
            found = [describe(mean_interval(_lost(values, learner, choice, budget))) for budget in BUDGETS]
            table.append([learner, choice, *found])
        for budget in BUDGETS:
            mine = _lost(values, learner, CLAIM, budget)
            kinds = [_lost(values, learner, choice, budget) for choice in REVIEWS if choice != CLAIM]
            gain = paired_difference(min(kinds, key=np.mean), mine).estimate
            better += [(learner, budget)] * (gain.low > 0)
            worse += [(learner, budget)] * (gain.high < 0)
            both = [_lost(values, learner, choice, budget) for choice in AT_ONCE]
            moved = max(moved, float(np.abs(both[0] - both[1]).max()))
    cells = len(LEARNERS) * len(BUDGETS)
    shown = [
        f"{describe(mean_interval(_lost(values, 'obedient, advice', choice, 20)))} ({choice})"
        for choice in (CLAIM, "three of a kind", "all of a kind")
    ]
    ours = (
        f"After an episode choosing the very claim is significantly better than the best of three ways to choose kinds "
        f"in {len(better)} of {cells} cases, and significantly worse in {len(worse)}. With 20 pieces of advice the "
        f"obedient student wastes {', '.join(shown)} moves an episode. At once both choices give "
        + (
            "the same in each lifetime."
            if moved == 0
            else f"regrets within {moved:.2f} moves an episode of each other."
        )
    )
    names = [f"{learner} with {budget}" for learner, budget in worse]
    why = (
        "At once a kind has one claim in a house, so that both choices are the same. After an episode it has many, "
        "most of them about rooms that were mentioned before; a personality can find where most is at stake (three or "
        "one "
        "of a kind), but not what is new." + (f" Significantly worse: {', '.join(names)}." if names else "")
    )
    agrees = "yes" if 2 * len(better) >= cells and not worse else "in part" if len(better) > len(worse) else "no"
    return Reading(agrees, ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by the number of claims, one panel per learner."""
    panels = figure.subplots(1, len(LEARNERS), sharey=True)
    for axes, learner in zip(panels, LEARNERS, strict=True):
        for choice in REVIEWS:
            found = [mean_interval(_lost(values, learner, choice, budget)) for budget in BUDGETS]
            line(axes, BUDGETS, found, choice)
        axes.set(title=learner, xlabel="claims in a lifetime", xscale="log")
        axes.set_xticks(BUDGETS, BUDGETS)
        axes.minorticks_off()
    panels[0].set_ylabel("regret per episode")
    panels[0].legend(fontsize="small")


ROW = Row(
    claim="A teacher that chooses the very claim teaches with fewer words than one that says all of its kind",
    source="Goldman & Kearns 1995 (teaching dimension), carried over to claims",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most {TURNS} moves from the same room, and {BUDGETS[0]} to "
        f"{BUDGETS[-1]} claims in all. The teacher speaks when an episode is over (`end_of_episode`), of any of its "
        "moves, or at once, of the last one, and only when something is new: whether an action in a room is right, "
        "which it has not said yet. Then it says that claim (of the new ones, right actions before wrong ones, and the "
        "rooms visited most first), or its kind: all claims of it, or the three or the one of them about moves at "
        "which most was at stake. Students learn from advice (fp) or verdicts (hp, hn) alone, but for "
        "Advise, which hears rewards, too. Figures are moves wasted per episode."
    ),
    settings=tuple(
        _setting(learner, choice, budget) for learner in LEARNERS for choice in REVIEWS | AT_ONCE for budget in BUDGETS
    ),
    seeds=50,
    measure=measure,
    measures=("regret per episode", "claims that were made"),
    read=read,
    draw=draw,
)
