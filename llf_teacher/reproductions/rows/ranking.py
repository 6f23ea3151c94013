"""Whether teachers rank alike for different students."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import kendalltau

from llf_teacher.reproductions.drawing import bars
from llf_teacher.reproductions.row import OURS, Reading, Row, Values, describe
from llf_teacher.reproductions.rows.half import BOTH, EPISODES, WORLDS, mean_regret
from llf_teacher.reproductions.rule import Expectation, Rule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHERS = (
    "oracle",
    "vague",
    "hinter",
    "delayed(turns=2)",
    "mistake(eps=0.3)",
    "only(kinds='hp+hn')",
    "only(kinds='fp')",
    "only(kinds='fn')",
)
FIRST = "obedient"
STUDENTS = {
    "the same": FIRST,
    "one that reasons": "reasoner(worlds=64)",
    "one that infers reliability": "bayesian",
    "a stubborn one": f"{FIRST} | stubborn(p=0.5)",
    "one that skips advice": f"{FIRST} | skims(kinds='fp')",
}
MEASURES = ("agreement of the rankings",)
LEAST = -0.2
"""The greatest loss of agreement that does not count."""


def measure(family: str, student: str, seed: int) -> Sequence[float]:
    """Kendall's rank correlation of the teachers' mean regrets for a student and, in other worlds, for `FIRST`."""
    first = 2 * EPISODES * seed
    one = [mean_regret(family, FIRST, teacher, first) for teacher in TEACHERS]
    other = [mean_regret(family, student, teacher, first + EPISODES) for teacher in TEACHERS]
    return [0.0 if np.ptp(one) == 0 or np.ptp(other) == 0 else float(kendalltau(one, other).statistic)]


def _setting(family: str, name: str) -> dict[str, str]:
    return {"family": family, "student": STUDENTS[name]}


def read(values: Values) -> Reading:
    """The agreement with the first student, by student."""
    found = {
        (family, name): describe(values.means(**_setting(family, name))[0]) for family in WORLDS for name in STUDENTS
    }
    table = [["family", "student", "agreement"]]
    for (family, name), agreement in found.items():
        table.append([family, f"{name} (`{STUDENTS[name].replace('|', 'with')}`)", agreement])
    parts = [
        f"in {family} {found[family, 'the same']} for the same student in other worlds, "
        + ", ".join(f"{found[family, name]} for {name}" for name in list(STUDENTS)[1:])
        for family in WORLDS
    ]
    why = (
        f"A ranking of {len(TEACHERS)} teachers by {EPISODES} worlds has noise of its own, which is why the rule "
        "compares with the same student in other worlds. Teachers that are equally good for one student, such as "
        "those whose advice it follows, have no order to agree on."
    )
    return Reading(f"Kendall's rank correlation of teachers: {'; '.join(parts)}.", why, table)


def draw(values: Values, figure: "Figure") -> None:
    """The agreement, by family and student."""
    axes = figure.subplots()
    found = {name: [values.means(**_setting(family, name))[0] for family in WORLDS] for name in STUDENTS}
    bars(axes, list(WORLDS), found)
    axes.set_ylabel("agreement with the first student")
    figure.legend(loc="outside lower center", ncols=3)


ROW = Row(
    claim="Teachers that are better for one student are better for another",
    source=OURS,
    protocol=(
        f"{BOTH} by {len(TEACHERS)} teachers: {', '.join(f'`{each}`' for each in TEACHERS)}. A seed has {EPISODES} "
        f"worlds in which each teaches `{FIRST}`, and {EPISODES} others in which each teaches the other student. The "
        "measure is Kendall's rank correlation (tau-b) of the teachers' mean regrets for both, 0 if all are equal for "
        "one of them."
    ),
    rule=Rule(
        seeds=12,
        comparisons=tuple(
            Expectation(
                expects=f"in {family} the ranking for {name} agrees as well as for the same student, less 0.2",
                more=(_setting(family, name),),
                less=(_setting(family, "the same"),),
                measure=MEASURES[0],
                least=LEAST,
            )
            for family in WORLDS
            for name in list(STUDENTS)[1:]
        ),
    ),
    settings=tuple(_setting(family, name) for family in WORLDS for name in STUDENTS),
    measure=measure,
    measures=MEASURES,
    read=read,
    draw=draw,
)
