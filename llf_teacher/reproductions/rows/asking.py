"""Who begins: a teacher who looks all the time, or a student who asks (Amir et al. 2016)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.asking import Answers, Asks, attended
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGET, EPISODES, TURNS, GREATEST = 20, 40, 40, 2.0
SURE, KNOWN = 0.1, 5
"""Difference of learned values from which on a student is sure; visits after which a state is familiar."""
ASKS: dict[str, Asks | None] = {
    "the teacher looks always": None,
    "asks where unsure": lambda values, _: max(values) - min(values) < SURE,
    "asks where it was seldom": lambda _, visits: visits < KNOWN,
    "asks where much is at stake": lambda values, _: max(values) - min(values) >= SURE,
}
ANSWERS: dict[str, Answers] = {
    "always": lambda importance, mistake: True,  # noqa: ARG005 (of all answers the same form)
    "important states": lambda importance, _: importance >= GREATEST,
    "important mistakes": lambda importance, mistake: mistake and importance >= GREATEST,
    "never": lambda importance, mistake: False,  # noqa: ARG005 (as above)
}
"""Of what a teacher sees, what it advises on."""
ALONE = ("the teacher looks always", "never")
WATCHED = ("the teacher looks always", "important mistakes")
ASKED = ("asks where unsure", "always")
JOINT = ("asks where unsure", "important mistakes")


def measure(asks: str, answers: str, seed: int) -> Sequence[float]:
    """Regret per episode, turns in which the teacher looked, and pieces of advice."""
    return attended(
        "llf-gridworld-v0", ASKS[asks], ANSWERS[answers], seed=seed, episodes=EPISODES, turns=TURNS, budget=BUDGET
    )


def _settings() -> list[dict[str, str]]:
    return [
        {"asks": asks, "answers": answers}
        for asks in ASKS
        for answers in ANSWERS
        if answers != "never" or (asks, answers) == ALONE
    ]


def _of(way: tuple[str, str]) -> dict[str, str]:
    return {"asks": way[0], "answers": way[1]}


def read(values: Values) -> Reading:
    """Regret, attention and advice, and what of the gain is kept with how much less attention."""
    table = [["the student", "the teacher advises on", "regret per episode", "turns it looked", "pieces of advice"]]
    for setting in _settings():
        cells = [describe(mean_interval(column)) for column in values(**setting).T[:3]]
        table.append([setting["asks"], setting["answers"], *cells])
    alone, watched, asked, joint = (values(**_of(way)) for way in (ALONE, WATCHED, ASKED, JOINT))
    worse = paired_difference(joint[:, 0], watched[:, 0]).estimate
    better = paired_difference(asked[:, 0], joint[:, 0]).estimate
    looks = [mean_interval(each[:, 1]) for each in (watched, joint)]
    less = paired_difference(watched[:, 1], joint[:, 1]).estimate
    gain = alone[:, 0].mean() - watched[:, 0].mean()
    kept = (alone[:, 0].mean() - joint[:, 0].mean()) / gain if gain else 0.0
    ours = (
        f"A teacher who looks always and corrects important mistakes looks in {describe(looks[0], 1)} turns; one who "
        f"does so when an unsure student asks, in {describe(looks[1], 1)}, and keeps {kept:.0%} of the gain: the "
        f"regret is higher by {describe(worse)} moves an episode. If all questions are answered it is higher by "
        f"{describe(better)} than that."
    )
    same = worse.low <= 0 or kept >= 0.95
    agrees = "yes" if less.low > 0 and same else "in part" if less.low > 0 and kept > 0.5 else "no"
    why = (
        "What a student asks matters: one who asks where its values differ much, as the paper's *ask important*, asks "
        "too late here, since all of its values are equal at first and rewards are rare; the paper's students had "
        "learned for some time before."
    )
    return Reading(agrees, ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by the attention that it took, a point a way."""
    axes = figure.subplots()
    markers = dict(zip(ANSWERS, "os^", strict=False))
    for number, asks in enumerate(ASKS):
        taught = [each for each in _settings() if each["asks"] == asks and each["answers"] != "never"]
        looks, lost = (np.array([values(**each)[:, column].mean() for each in taught]) for column in (1, 0))
        axes.plot(looks, lost, color=f"C{number}", label=asks)
        for marker, *point in zip(markers.values(), looks, lost, strict=True):
            axes.plot(*point, color=f"C{number}", marker=marker)
    for answers, marker in markers.items():
        axes.plot([], [], color="gray", linestyle="", marker=marker, label=f"advises {answers}")
    axes.axhline(values(**_of(ALONE))[:, 0].mean(), color="gray", linestyle="--", label="no advice")
    axes.set(xlabel="turns in which the teacher looked", ylabel="regret per episode", ylim=(0, None))
    axes.legend(loc="center right")


ROW = Row(
    claim="Advising that both initiate gains nearly as much as a teacher who always looks, with less attention",
    source="Amir et al. 2016",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most {TURNS} moves from the same room, {BUDGET} pieces of "
        "advice in all. The student is Q-learning, takes the advised action for the turn, and announces what it means "
        "to do. A teacher looks in each turn, or where the student asks (`ask_cost=0`), as long as it has advice left: "
        f"where learned values differ by less than {SURE:g} (unsure) or by more, or in the first {KNOWN} visits of a "
        f"room. It advises always, in states in which {GREATEST:g} moves are at stake, or on mistakes in such states. "
        "Thresholds were chosen on other seeds. The paper has Pac-Man."
    ),
    settings=tuple(_settings()),
    seeds=60,
    measure=measure,
    measures=("regret per episode", "turns in which the teacher looked", "pieces of advice"),
    read=read,
    draw=draw,
)
