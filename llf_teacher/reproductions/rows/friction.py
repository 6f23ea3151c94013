"""Gold, wrong, placebo and retry: which students use feedback, and how far they stay below the ceiling (Jiang 2025)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.lessons import regrets, total
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference
from worlds.batches import Floats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IDS = {
    "alfworld": "llf-alfworld-v0",
    "bandits": "llf-bandits-BanditTenArmedRandomFixed-v0",
    "gridworld": "llf-gridworld-v0",
    "metaworld": "llf-metaworld-reach-v3",
    "movies": "llf-reco-movie-v0",
    "optimization": "llf-optimization-Booth-v0",
    "parking": "llf-highway-parking-v0",
    "poem": "llf-poem-SyllableConstrainedPoem-v0",
}
TEACHERS = {"gold": "oracle", "wrong": "mistake(eps=1)", "placebo": "placebo", "retry": "retry_only"}
STUDENTS = ("obedient", "text_only", "reward_only")
SOME = {
    "bayesian": ("bandits", "gridworld"),
    "tamer": ("bandits", "gridworld"),
    "coach": ("bandits", "gridworld"),
    "sabl": ("bandits", "gridworld"),
    "advise": ("bandits", "gridworld"),
    "q_learning(trust=1.0)": ("gridworld",),
    "ucb(trust=1.0)": ("bandits",),
    "nelder_mead(trust=1.0)": ("optimization",),
}
"""Students that play in some families only."""
CEILING = "oracle"
ATTEMPTS = (1, 3, 10)
"""Numbers of turns within which successes are counted."""


def measure(id: str, student: str, teacher: str, seed: int) -> Sequence[float]:
    """Total regret, and the turn of the first success; 0 if there was none."""
    lost, solved = regrets(id, student=student, teacher=teacher, seed=seed)
    return [total(lost), float(solved.index(True) + 1 if any(solved) else 0)]


def _pairs() -> list[tuple[str, str]]:
    return [
        (family, student)
        for family in IDS
        for student in (*STUDENTS, *(name for name, families in SOME.items() if family in families))
    ]


def _setting(family: str, student: str, teacher: str) -> dict[str, str]:
    return {"id": IDS[family], "student": student, "teacher": TEACHERS[teacher]}


def read(values: Values) -> Reading:
    """Regret by teacher, and the students that are significantly better or worse than with retry."""
    within = f"solved within {', '.join(map(str, ATTEMPTS))}"
    table = [
        ["family", "student", *(f"{name}: regret" for name in TEACHERS), *(f"{name}: {within}" for name in TEACHERS)]
    ]
    helped, harmed, fooled, moved = [], [], [], []
    reading = [pair for pair in _pairs() if pair[1] != "reward_only"]
    for family, student in _pairs():
        found = {name: values(**_setting(family, student, name)) for name in TEACHERS}
        rates = [_solved(each[:, 1]) for each in found.values()]
        table.append([family, student, *(describe(mean_interval(each[:, 0])) for each in found.values()), *rates])
        retry = found["retry"][:, 0]
        if (family, student) in reading:
            gain = {name: paired_difference(retry, found[name][:, 0]).estimate for name in TEACHERS if name != "retry"}
            helped += [(family, student)] * (gain["gold"].low > 0)
            harmed += [(family, student)] * (gain["wrong"].high < 0)
            fooled += [(family, student)] * (gain["placebo"].low > 0)
            moved += [(family, student)] * (gain["placebo"].high < 0)
    short = [
        pair for pair in reading if values(**_setting(*pair, "gold"))[:, 0].mean() > _ceiling(values, pair[0]) + 1e-6
    ]
    ours = (
        f"Of {len(reading)} pairs of a family and a student that reads feedback, gold feedback significantly helps "
        f"{len(helped)}, wrong feedback significantly harms {len(harmed)}, and a placebo significantly helps "
        f"{len(fooled)} and harms {len(moved)}, against retrying. {len(short)} stay below the ceiling with gold "
        "feedback."
    )
    proof = [f"{student} in {family}" for family, student in reading if (family, student) not in harmed]
    why = (
        f"Not significantly harmed by wrong feedback: {', '.join(proof) or 'none'}. A placebo is true and useless, so "
        "that students that read claims gain nothing from it, as expected. Regret with gold feedback comes from turns "
        "before the first advice, from advice that names a step and not the goal, and, for students that learn from "
        "verdicts alone, from turns before they try the right action; the paper's models lose more because they do not "
        "use the feedback."
    )
    return Reading("yes" if helped and short else "no", ours, why, table)


def _solved(first: Floats) -> str:
    """Shares of seeds with the first success within each number of turns; 0 is no success."""
    return ", ".join(f"{np.mean((first > 0) & (first <= attempts)):.0%}" for attempts in ATTEMPTS)


def _ceiling(values: Values, family: str) -> float:
    return float(values(id=IDS[family], student=CEILING, teacher=TEACHERS["gold"])[:, 0].mean())


def draw(values: Values, figure: "Figure") -> None:
    """Regret as a share of that with retry, one panel per family."""
    figure.set_size_inches(9, 7)
    panels = figure.subplots(2, len(IDS) // 2, sharey=True)
    for axes, family in zip(panels.flat, IDS, strict=True):
        students = [student for where, student in _pairs() if where == family]
        for number, name in enumerate(TEACHERS):
            shares = []
            for student in students:
                retry = max(values(**_setting(family, student, "retry"))[:, 0].mean(), 1e-9)
                shares.append(values(**_setting(family, student, name))[:, 0].mean() / retry)
            axes.bar(np.arange(len(students)) + (number - 1.5) * 0.2, shares, 0.2, label=name)
        axes.set_xticks(range(len(students)), [student.partition("(")[0] for student in students], rotation=90)
        axes.set_title(family)
    panels[0, 0].set_ylabel("regret / regret under retry")
    panels[0, 0].legend(fontsize="small")


ROW = Row(
    claim="Even with gold feedback students plateau below the ceiling; wrong feedback harms students that believe it",
    source="Jiang et al. 2025 (Feedback Friction, arXiv 2506.11930)",
    protocol=(
        "Eight families at their own horizons, all kinds of feedback. Beside students that read there are students "
        "that learn from verdicts, or from rewards with trust in advice, in suitable families. Gold is the oracle, "
        "wrong replaces each claim by a plausible falsehood (`mistake(eps=1)`), placebo says true and useless "
        "sentences, retry says only that the action was not right. The ceiling is the student `oracle`. Bandits, "
        "poems, films and optimization ask the same problem again, up to 30 or 10 times: there a turn is an attempt. "
        "The paper has language models and benchmarks of questions."
    ),
    settings=(
        *({"id": id, "student": CEILING, "teacher": TEACHERS["gold"]} for id in IDS.values()),
        *(_setting(family, student, teacher) for family, student in _pairs() for teacher in TEACHERS),
    ),
    seeds=20,
    measure=measure,
    measures=("total regret", "turn of the first success, 0 if there was none"),
    read=read,
    draw=draw,
)
