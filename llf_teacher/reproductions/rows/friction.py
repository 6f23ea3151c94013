"""Gold, wrong, placebo and retry: which students use feedback, and how far they stay below the ceiling (Jiang 2025)."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from llf_teacher.reproductions.lessons import regrets, total
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import TENTH, Expectation, Rule, Setting
from llf_teacher.studies.analysis.statistics import Estimate, mean_interval, paired_difference
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
CEILING, READER = "oracle", "text_only"
"""The student that follows the plan, and the one that the rule is about: it reads the teacher's words, as models do."""
REGRET = "total regret"
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
    """Regret by teacher, and what the reader lacks to the ceiling with gold feedback."""
    within = f"solved within {', '.join(map(str, ATTEMPTS))}"
    table = [
        ["family", "student", *(f"{name}: regret" for name in TEACHERS), *(f"{name}: {within}" for name in TEACHERS)]
    ]
    for family, student in _pairs():
        found = {name: values(**_setting(family, student, name)) for name in TEACHERS}
        rates = [_solved(each[:, 1]) for each in found.values()]
        table.append([family, student, *(describe(mean_interval(each[:, 0])) for each in found.values()), *rates])
    lacks = {family: _beside(values, _setting(family, READER, "gold"), _ceiling(family)) for family in IDS}
    harm = {
        family: _beside(values, _setting(family, READER, "wrong"), _setting(family, READER, "retry")) for family in IDS
    }
    ours = (
        f"With gold feedback {READER} loses this much more than the ceiling: {_listed(lacks)}. With wrong feedback it "
        f"loses this much more than with retry: {_listed(harm)}."
    )
    why = (
        "The paper's models have good feedback and do not use all of it. Our readers are programs that do what they "
        "are told as soon as they are told, so that no friction is left with gold feedback; models, which may choose "
        "not to follow, are not tried here. Wrong feedback has little room to harm where retrying already loses nearly "
        "all that can be lost, and where a mistaken action is no worse than one at random. Students that "
        "learn from verdicts alone, or from rewards, are in the table and not in the rule: what they lose before they "
        "try the right action is not friction with feedback, and some of them ignore advice. A placebo is true and "
        "useless, so that students that read claims gain nothing from it."
    )
    return Reading(ours, why, table)


def _beside(values: Values, more: Setting, less: Setting) -> Estimate:
    return paired_difference(values(**more)[:, 0], values(**less)[:, 0]).estimate


def _listed(found: Mapping[str, Estimate]) -> str:
    return ", ".join(f"{describe(each)} ({family})" for family, each in found.items())


def _solved(first: Floats) -> str:
    """Shares of seeds with the first success within each number of turns; 0 is no success."""
    return ", ".join(f"{np.mean((first > 0) & (first <= attempts)):.0%}" for attempts in ATTEMPTS)


def _ceiling(family: str) -> dict[str, str]:
    return {"id": IDS[family], "student": CEILING, "teacher": TEACHERS["gold"]}


def _expected(expects: str, family: str, more: Setting, less: Setting) -> Expectation:
    """A loss of at least a tenth of what the reader loses in a family with retry."""
    return Expectation(
        expects=f"{READER} in {family} {expects}",
        more=(more,),
        less=(less,),
        measure=REGRET,
        least=TENTH,
        share_of=_setting(family, READER, "retry"),
    )


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
        "sentences, retry says only that the action was not right. The ceiling is the student `oracle`. The rule is "
        f"about the student that reads the teacher's words (`{READER}`), and about differences of at least a tenth of "
        "what it loses with retry. Bandits, poems, films and optimization ask the same problem again, up to 30 or 10 "
        "times: there a turn is an attempt. The paper has language models and benchmarks of questions."
    ),
    settings=(
        *map(_ceiling, IDS),
        *(_setting(family, student, teacher) for family, student in _pairs() for teacher in TEACHERS),
    ),
    rule=Rule(
        seeds=12,
        comparisons=(
            *(
                _expected(
                    "stays below the ceiling with gold feedback",
                    family,
                    _setting(family, READER, "gold"),
                    _ceiling(family),
                )
                for family in IDS
            ),
            *(
                _expected(
                    "loses more with wrong feedback than with retry",
                    family,
                    _setting(family, READER, "wrong"),
                    _setting(family, READER, "retry"),
                )
                for family in IDS
            ),
        ),
    ),
    measure=measure,
    measures=(REGRET, "turn of the first success, 0 if there was none"),
    read=read,
    draw=draw,
)
