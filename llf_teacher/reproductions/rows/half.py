"""A teacher who knows about half, calibrated or too sure of itself, for students who trust, weigh and forget."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.lessons import regrets, total
from llf_teacher.reproductions.row import OURS, Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WORLDS: dict[str, tuple[str, dict[str, Any]]] = {
    "bandits": ("llf-bandits-BanditTenArmedRandomFixed-v0", {}),
    "gridworld": ("llf-gridworld-v0", {"map": True}),
}
"""The families whose students have both a posterior and values: an environment and its options."""
EPISODES, TURNS = 8, 12
"""Lessons of a seed for each teacher and student, each in another world; turns of each."""
BOTH = f"Ten-armed bandits, and houses whose plan is in the instruction; lessons of {TURNS} turns"
"""These lessons in words."""
HALF = "partial(sees='walk', steps=20)"
TEACHERS = {
    "silence": "silent",
    "calibrated": HALF,
    "overconfident": f"{HALF} | overconfident(by=5.0)",
    "all": "oracle",
}
STUDENTS = {
    "trusts": "reasoner(worlds=64)",
    "weighs": "reasoner(worlds=64, trust=0.8)",
    "forgets": "reasoner(worlds=64) | forgetful(half_life=3)",
}
MEASURES = ("regret",)


def mean_regret(family: str, student: str, teacher: str, first: int) -> float:
    """The mean regret of `EPISODES` lessons in a family of `WORLDS`, with seeds from `first` on."""
    id, options = WORLDS[family]
    seeds = range(first, first + EPISODES)
    lost = [regrets(id, student=student, teacher=teacher, seed=each, turns=TURNS, **options)[0] for each in seeds]
    return total(list(map(total, lost))) / EPISODES


def measure(family: str, student: str, teacher: str, seed: int) -> Sequence[float]:
    """The mean regret of a lesson."""
    return [mean_regret(family, student, teacher, EPISODES * seed)]


def _setting(family: str, student: str, teacher: str) -> dict[str, str]:
    return {"family": family, "student": STUDENTS[student], "teacher": TEACHERS[teacher]}


def read(values: Values) -> Reading:
    """Regret by teacher and student."""
    table = [["family", "student", *TEACHERS]]
    for family in WORLDS:
        for student in STUDENTS:
            found = (values.means(**_setting(family, student, teacher))[0] for teacher in TEACHERS)
            table.append([family, student, *map(describe, found)])

    def mean(family: str, teacher: str) -> float:
        return float(values(**_setting(family, "trusts", teacher)).mean())

    parts = [
        f"in {family} {mean(family, 'silence'):.2f} in silence, {mean(family, 'calibrated'):.2f} with the calibrated "
        f"teacher, {mean(family, 'overconfident'):.2f} with the overconfident one"
        for family in WORLDS
    ]
    why = (
        "The teacher's evidence is a walk of 20 random actions through the same world, with all rewards. It says what "
        "its oracle would say in most of the worlds that agree with it. The student takes a hedge for one more piece "
        "of evidence beside its own, and the evidence of both overlaps."
    )
    return Reading(f"Regret of the student that trusts: {'; '.join(parts)}.", why, table)


def draw(values: Values, figure: "Figure") -> None:
    """Regret by student, for each teacher."""
    panels = figure.subplots(1, len(WORLDS))
    for axes, family in zip(panels, WORLDS, strict=True):
        found = {
            teacher: [values.means(**_setting(family, student, teacher))[0] for student in STUDENTS]
            for teacher in TEACHERS
        }
        bars(axes, list(STUDENTS), found)
        axes.set(title=family, ylabel="regret")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)


ROW = Row(
    claim="A teacher who knows half and says how sure it is helps, and one that is too sure helps less",
    source=OURS,
    protocol=(
        f"{BOTH}. The teacher `{HALF}` does not know the truth, and hedges what it is not certain of; "
        "`overconfident(by=5.0)` multiplies the log-odds of its hedges by five. Students: `reasoner(worlds=64)`, which "
        "trusts; with `trust=0.8`, which weighs; with `forgetful(half_life=3)`, which forgets. The measure is the mean "
        f"regret of {EPISODES} lessons in different worlds, the same for all."
    ),
    rule=Rule(
        seeds=12,
        comparisons=(
            *(
                saves(
                    f"in {family} the calibrated teacher saves a student that {student} a tenth beside silence",
                    _setting(family, student, "calibrated"),
                    _setting(family, student, "silence"),
                    MEASURES[0],
                )
                for family in WORLDS
                for student in STUDENTS
            ),
            *(
                saves(
                    f"in {family} the calibrated teacher saves one that trusts a tenth beside the overconfident one",
                    _setting(family, "trusts", "calibrated"),
                    _setting(family, "trusts", "overconfident"),
                    MEASURES[0],
                )
                for family in WORLDS
            ),
        ),
    ),
    settings=tuple(
        _setting(family, student, teacher) for family in WORLDS for student in STUDENTS for teacher in TEACHERS
    ),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
