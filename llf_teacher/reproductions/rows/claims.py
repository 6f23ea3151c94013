"""Choosing a single claim beside choosing a kind, at equal numbers of claims (Goldman & Kearns 1995)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.reproductions.drawing import line, name_lines
from llf_teacher.reproductions.reviews import commented
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EPISODES, TURNS, BUDGETS = 20, 40, (5, 10, 20, 40)
FEW = BUDGETS[:2]
"""Budgets at which words are few: with more of them nearly all can be said."""
REGRET = "regret per episode"
LEARNERS = {
    "obedient, advice": ("obedient(forget=False)", "fp"),
    "text_only, verdicts": ("text_only(forget=False)", "hp+hn"),
    "SABL, verdicts": ("sabl(forget=False)", "hp+hn"),
    "Advise, verdicts": ("advise(forget=False)", "hp+hn"),
}
"""The learner and its kinds of claims."""
CLAIM, NEW = "the very claim", "the new ones of a kind"
REVIEWS = {
    "all of a kind": ("end_of_episode(top_k=32)", "kinds"),
    "three of a kind": ("end_of_episode(top_k=3)", "kinds"),
    "one of a kind": ("end_of_episode(top_k=1)", "kinds"),
    NEW: ("end_of_episode(top_k=32)", "new"),
    CLAIM: ("end_of_episode(top_k=32)", "claims"),
}
"""A teacher's choice after an episode: the personality that offers claims, and the form of speech.

Only `NEW` and `CLAIM` say nothing twice, so that these two choose with equal knowledge.
"""
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
    """Regret by budget, and what choosing claims saves beside choosing kinds, with equal and with less knowledge."""
    table = [["learner", "the teacher chooses", *(f"{budget} claims" for budget in BUDGETS)]]
    moved = 0.0
    for learner in LEARNERS:
        for choice in REVIEWS | AT_ONCE:
            found = [describe(mean_interval(_lost(values, learner, choice, budget))) for budget in BUDGETS]
            table.append([learner, choice, *found])
        for budget in BUDGETS:
            both = [_lost(values, learner, choice, budget) for choice in AT_ONCE]
            moved = max(moved, float(np.abs(both[0] - both[1]).max()))
    shown = [
        f"{describe(mean_interval(_lost(values, 'obedient, advice', choice, FEW[-1])))} ({choice})"
        for choice in (CLAIM, NEW, "three of a kind", "all of a kind")
    ]
    saved = []
    for learner in LEARNERS:
        new, mine = (_lost(values, learner, choice, FEW[-1]) for choice in (NEW, CLAIM))
        saved.append(f"{describe(paired_difference(new, mine).estimate)} ({learner})")
    ours = (
        f"After an episode, with {FEW[-1]} pieces of advice, the obedient student wastes {', '.join(shown)} moves an "
        f"episode. Beside a teacher that knows as much, choosing the very claim saves {', '.join(saved)} with "
        f"{FEW[-1]} claims. At once claims and kinds give "
        + (
            "the same in each lifetime."
            if moved == 0
            else f"regrets within {moved:.2f} moves an episode of each other."
        )
    )
    why = (
        "At once a kind has one claim in a house, so that both choices are the same. After an episode it has many, "
        "most of them about rooms that were mentioned before. A teacher that names kinds repeats them, and a "
        "personality that finds where most is at stake (three or one of a kind) does, too; so a lead over these is due "
        "to knowing what is new. Beside a teacher that knows as much only the order is left: right actions before "
        "wrong ones, and the rooms visited most before others, instead of the order of the moves. A better order was "
        "not sought."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by the number of claims, one panel per learner."""
    figure.set_size_inches(9, 7)
    panels = figure.subplots(2, len(LEARNERS) // 2, sharey=True)
    for axes, learner in zip(panels.flat, LEARNERS, strict=True):
        for choice in REVIEWS:
            found = [mean_interval(_lost(values, learner, choice, budget)) for budget in BUDGETS]
            line(axes, BUDGETS, found, choice)
        axes.set(title=learner, xlabel="claims in a lifetime", xscale="log")
        axes.set_xticks(BUDGETS, BUDGETS)
        axes.minorticks_off()
    for axes in panels[:, 0]:
        axes.set_ylabel("regret per episode")
    name_lines(figure)


ROW = Row(
    claim="A teacher that chooses the very claim teaches with fewer words than one that says all of its kind",
    source="Goldman & Kearns 1995 (teaching dimension), carried over to claims",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most {TURNS} moves from the same room, and {BUDGETS[0]} to "
        f"{BUDGETS[-1]} claims in all. The teacher speaks when an episode is over (`end_of_episode`), of any of its "
        "moves, or at once, of the last one, and only when something is new: whether an action in a room is right, "
        "which it has not said yet. Then it says new claims one by one (right actions before wrong ones, and the rooms "
        "visited most first), the new claims of a kind in the order of the moves, or a kind: all claims of it, or the "
        "three or the one of them about moves at which most was at stake, also if they were said before. The rule "
        "compares the first two, which know the same, while claims are few. Students learn from advice (fp) or "
        "verdicts (hp, hn) alone, but for "
        "Advise, which hears rewards, too. Figures are moves wasted per episode."
    ),
    settings=tuple(
        _setting(learner, choice, budget) for learner in LEARNERS for choice in REVIEWS | AT_ONCE for budget in BUDGETS
    ),
    rule=Rule(
        seeds=20,
        comparisons=tuple(
            saves(
                f"choosing the very claim wastes less than the new ones of a kind, with {budget} claims ({learner})",
                _setting(learner, CLAIM, budget),
                _setting(learner, NEW, budget),
                REGRET,
            )
            for learner in LEARNERS
            for budget in FEW
        ),
    ),
    measure=measure,
    measures=(REGRET, "claims that were made"),
    read=read,
    draw=draw,
)
