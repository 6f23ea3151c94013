"""The order of learners with irrational teachers (B-Pref: Lee et al. 2021)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from llf_teacher.reproductions.lifetimes import live
from llf_teacher.reproductions.row import Reading, Row, Values, describe
from llf_teacher.reproductions.rule import Rule, saves
from llf_teacher.studies.analysis.statistics import paired_difference

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VERDICTS = "only(kinds='hp+hn')"
TEACHERS = {
    "oracle": VERDICTS,
    "mistake, 10 %": f"mistake(eps=0.1) | {VERDICTS}",
    "mistake, 30 %": f"mistake(eps=0.3) | {VERDICTS}",
    "skip": f"skip | {VERDICTS}",
    "equal": f"equal | {VERDICTS}",
    "myopic": f"myopic | {VERDICTS}",
    "stochastic": f"noisy | {VERDICTS}",
    "inactive": f"inactive | {VERDICTS}",
    "blames": f"punishment_focused | {VERDICTS}",
    "praises": f"reward_focused | {VERDICTS}",
    "late": f"{VERDICTS} | delayed(turns=2)",
    "used to it": f"policy_dependent | {VERDICTS}",
}
LEARNERS = {
    "TAMER": "tamer(forget=False)",
    "COACH": "coach(forget=False)",
    "E-COACH": "coach(forget=False, episodic=True, alpha=0.1)",
    "SABL": "sabl(forget=False)",
    "I-SABL": "sabl(forget=False, infers=True)",
    "Advise": "advise(forget=False)",
}
REGRET, ROBUST, ERRS = "regret per episode", "Advise", "mistake, 30 %"
"""What is compared; the learner that is expected to be best where the teacher often errs, and that teacher."""


def measure(student: str, teacher: str, seed: int) -> Sequence[float]:
    """Regret per episode of a lifetime."""
    *lost, _ = live("llf-gridworld-v0", student=student, teacher=teacher, episodes=30, turns=40, seed=seed)
    return [float(np.mean(lost))]


def _means(values: Values, teacher: str) -> list[float]:
    return [float(values(student=s, teacher=TEACHERS[teacher]).mean()) for s in LEARNERS.values()]


def agreement(values: Values, teacher: str) -> float:
    """Kendall's tau-b of the orders of learners with a teacher and with the oracle, -1 to 1."""
    return float(stats.kendalltau(_means(values, "oracle"), _means(values, teacher)).statistic)


def read(values: Values) -> Reading:
    """Orders of learners, and their agreement with the oracle's."""
    table = [["teacher", *LEARNERS, "least regret", "tau with the oracle's order"]]
    first, taus = {}, {}
    for teacher in TEACHERS:
        means = _means(values, teacher)
        first[teacher] = [learner for learner, mean in zip(LEARNERS, means, strict=True) if mean == min(means)]
        taus[teacher] = agreement(values, teacher)
        cells = [describe(values.means(student=s, teacher=TEACHERS[teacher])[0]) for s in LEARNERS.values()]
        table.append([teacher, *cells, ", ".join(first[teacher]), f"{taus[teacher]:.2f}"])
    broken = sorted((teacher for teacher in TEACHERS if teacher != "oracle"), key=taus.__getitem__)
    known = set(first["oracle"])
    robust = {
        other: paired_difference(values(**_setting(other, ERRS))[:, 0], values(**_setting(ROBUST, ERRS))[:, 0]).estimate
        for other in ("TAMER", "SABL")
    }
    ours = (
        f"Where a teacher errs in 30 %, {ROBUST} wastes {describe(robust['TAMER'])} moves an episode less than TAMER, "
        f"and {describe(robust['SABL'])} less than SABL. Under the oracle {', '.join(first['oracle'])} waste least; "
        f"another learner does with {sum(not known & set(first[teacher]) for teacher in broken)} of {len(broken)} "
        f"teachers. Kendall's tau with the oracle's order is between {taus[broken[0]]:.2f} ({broken[0]}) and "
        f"{taus[broken[-1]]:.2f} ({broken[-1]})."
    )
    why = (
        "Learners whose choices are the same under a teacher are tied there: TAMER and both forms of SABL are equal "
        "under an oracle that always speaks, so that a change of the least among them is no change of order. The rule "
        "is about one reversal, which the learners' assumptions predict: Advise expects wrong labels and hears "
        "rewards, TAMER believes each label. SABL expects wrong labels, too. Others in the table were not predicted, "
        "and are no evidence by themselves."
    )
    return Reading(ours, why, table)


def _setting(learner: str, teacher: str) -> dict[str, str]:
    return {"student": LEARNERS[learner], "teacher": TEACHERS[teacher]}


def draw(values: Values, figure: "Figure") -> None:
    """A map of mean regrets, on a logarithmic scale."""
    axes = figure.subplots()
    table = np.array([_means(values, teacher) for teacher in TEACHERS])
    image = axes.imshow(np.log10(table + 0.1), aspect="auto", cmap="cividis_r")
    axes.set_xticks(range(len(LEARNERS)), LEARNERS)
    axes.set_yticks(range(len(TEACHERS)), TEACHERS)
    for (row, column), value in np.ndenumerate(table):
        axes.text(column, row, f"{value:.1f}", ha="center", va="center", color="white" if value > 3 else "black")
    figure.colorbar(image, label="log10 of regret per episode + 0.1")


ROW = Row(
    claim="Which learner is best depends on how irrational the teacher is",
    source="Lee et al. 2021 (B-Pref)",
    protocol=(
        "Six learners from verdicts in houses of 20 rooms, 30 episodes of at most 40 moves from the same room, under "
        "the oracle and eleven teachers that err, skip, are short-sighted, silent, late or used to good work. Figures "
        "are moves wasted per episode. B-Pref has preferences over segments and deep learners; its question is asked "
        "here of verdicts."
    ),
    rule=Rule(
        seeds=24,
        comparisons=(
            saves(
                f"{ROBUST} is not the best under the oracle: TAMER wastes less",
                _setting("TAMER", "oracle"),
                _setting(ROBUST, "oracle"),
                REGRET,
            ),
            *(
                saves(
                    f"{ROBUST} is the best under a teacher that errs in 30 %: it wastes less than {other}",
                    _setting(ROBUST, ERRS),
                    _setting(other, ERRS),
                    REGRET,
                )
                for other in LEARNERS
                if other != ROBUST
            ),
        ),
    ),
    settings=tuple(_setting(learner, teacher) for learner in LEARNERS for teacher in TEACHERS),
    measure=measure,
    measures=(REGRET,),
    read=read,
    draw=draw,
)
