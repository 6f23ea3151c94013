"""Initiative: a teacher that always looks, or a student that asks (Amir et al. 2016)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.asking import Answers, Asks, attended
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import TENTH, Expectation, Rule, saves
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGET, EPISODES, TURNS, GREATEST = 20, 40, 40, 2.0
CONFIDENT, KNOWN = 0.1, 5
"""Difference of learned values from which a student is confident; visits after which a state is familiar."""
ASKS: dict[str, Asks | None] = {
    "the teacher looks always": None,
    "asks where unsure": lambda values, _: max(values) - min(values) < CONFIDENT,
    "asks where it was seldom": lambda _, visits: visits < KNOWN,
    "asks where much is at stake": lambda values, _: max(values) - min(values) >= CONFIDENT,
}
ANSWERS: dict[str, Answers] = {
    "always": lambda importance, mistake: True,  # noqa: ARG005 (of all answers the same form)
    "important states": lambda importance, _: importance >= GREATEST,
    "important mistakes": lambda importance, mistake: mistake and importance >= GREATEST,
    "never": lambda importance, mistake: False,  # noqa: ARG005 (as above)
}
"""When a teacher that looks gives advice."""
ALONE = ("the teacher looks always", "never")
WATCHED = ("the teacher looks always", "important mistakes")
ASKED = ("asks where unsure", "always")
JOINT = ("asks where unsure", "important mistakes")
REGRET, LOOKED, SAID = MEASURES = "regret per episode", "turns in which the teacher looked", "pieces of advice"


def measure(asks: str, answers: str, seed: int) -> Sequence[float]:
    """Regret per episode, number of turns in which the teacher looked, and pieces of advice."""
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
    """Regret, attention and advice, and the share of the gain that remains with less attention."""
    table = [["the student", "the teacher advises on", "regret per episode", "turns it looked", "pieces of advice"]]
    for setting in _settings():
        cells = [describe(mean_interval(column)) for column in values(**setting).T[:3]]
        table.append([setting["asks"], setting["answers"], *cells])
    alone, watched, asked, joint = (values(**_of(way)) for way in (ALONE, WATCHED, ASKED, JOINT))
    worse = paired_difference(joint[:, 0], watched[:, 0]).estimate
    better = paired_difference(asked[:, 0], joint[:, 0]).estimate
    looks = [mean_interval(each[:, 1]) for each in (watched, joint)]
    gain = alone[:, 0].mean() - watched[:, 0].mean()
    kept = (alone[:, 0].mean() - joint[:, 0].mean()) / gain if gain else 0.0
    ours = (
        f"A teacher that always looks and corrects important mistakes looks in {describe(looks[0], 1)} turns. If it "
        f"looks only when an unsure student asks, it looks in {describe(looks[1], 1)} and keeps {kept:.0%} of the "
        f"gain: the regret is higher by {describe(worse)} moves an episode, and by {describe(better)} more if the "
        "teacher answers all questions."
    )
    why = (
        "The student's rule matters: asking where values differ much, as the paper's *ask important*, comes too late "
        "here, since all values are equal at first and rewards are rare; the paper's students had learned for some "
        "time before."
    )
    return Reading(ours, why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret against attention, one point per way to ask and to answer."""
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
    claim="Advising that both initiate gains nearly as much as a teacher that always looks, with less attention",
    source="Amir et al. 2016",
    protocol=(
        f"Houses of 20 rooms, {EPISODES} episodes of at most {TURNS} moves from the same room, {BUDGET} pieces of "
        "advice in all. The student is Q-learning, takes the advised action for the turn, and announces what it means "
        "to do. A teacher looks in each turn, or where the student asks (`ask_cost=0`), while it has advice left: "
        f"where learned values differ by less than {CONFIDENT:g} (unsure) or by more, or in the first {KNOWN} visits "
        f"of a room. It advises always, in states in which {GREATEST:g} moves are at stake, or on mistakes in such "
        "states. Thresholds were chosen on other seeds. The paper has Pac-Man."
    ),
    rule=Rule(
        seeds=75,
        comparisons=(
            saves("a teacher that looks only when it is asked looks less", _of(JOINT), _of(WATCHED), LOOKED),
            Expectation(
                expects="and its students waste hardly more: at most a tenth of what is wasted without advice",
                more=(_of(WATCHED),),
                less=(_of(JOINT),),
                measure=REGRET,
                least=-TENTH,
                share_of=_of(ALONE),
            ),
        ),
    ),
    settings=tuple(_settings()),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
