"""The findings of a study: its primary test, the largest significant surprise, and the seeds that are still needed.

A difference is a surprise if it contradicts the accounts of the teachers: the teacher with the greater share of true,
timely claims minus distorted ones should be better, and teachers with equal shares should not differ.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.studies.analysis.primary import Primary, enough, least
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import gain_plot
from llf_teacher.studies.report.section import share
from teachers.atoms import Label
from teachers.words import type_words

_ALIKE = 0.1  # with a smaller difference of shares no effect is expected


class ClaimShares(NamedTuple):
    """Shares of a teacher's claims, 0 to 1."""

    truthful: float
    """True and in time."""
    distorted: float
    """Not true in the simulator."""

    @property
    def worth(self) -> float:
        """The expected value of a claim, -1 to 1."""
        return self.truthful - self.distorted


class Surprise(NamedTuple):
    """A significant comparison that contradicts the shares of claims."""

    found: Primary
    teacher: ClaimShares
    baseline: ClaimShares


class Needed(NamedTuple):
    """The additional seeds that comparisons need for a power of 80 % at the observed scores."""

    open: int
    """Number of comparisons that are not significant."""
    nearest: Primary
    """The comparison that needs the fewest seeds."""
    fewest: int
    all: int
    """Seeds for every open comparison with an observed difference."""


class Tally(NamedTuple):
    """Number of primary comparisons, and of significant ones."""

    all: int
    better: int
    worse: int


def _values(data: Data) -> Mapping[str, Any]:
    primary = data.primary
    if not primary:
        return {"missing": _missing(data)}
    significant = data.significant
    lowest = least(primary, data.test) if data.test else 0.0
    return {
        "missing": "",
        "baseline": data.study.baseline,
        "plot": _plot(data, data.compared),
        "seeds": max(each.score.estimate.n for each in primary),
        "families": len({group.family for each in primary for group in each.families}),
        "typed": _typed(primary),
        "least": lowest if data.test and lowest > data.test.level else None,
        "enough": enough(len(primary)),
        "tested": _tally(primary, significant) if data.test else None,
        "largest": max(significant, key=lambda each: abs(each.mean), default=None),
        "surprise": _surprise(data, significant),
        "needed": _needed(primary, significant),
        "exploratory": len(data.compared) - len(primary),
    }


def _missing(data: Data) -> str:
    """Why there is no comparison."""
    if data.study.baseline not in data.study.teachers:
        return "baseline"
    return "pairs" if data.present < data.expected else "hearing"


def _typed(found: Sequence[Primary]) -> bool:
    return len({each.compared[2:] for each in found}) > 1


def _tally(primary: Sequence[Primary], significant: Sequence[Primary]) -> Tally:
    better = sum(each.mean > 0 for each in significant)
    return Tally(len(primary), better, len(significant) - better)


def said(data: Data, teacher: str, like: Primary) -> ClaimShares:
    """The account of a teacher's claims to the student of a comparison."""
    mine = [
        each
        for setting, each in data.sums.items()
        if (teacher, *like.compared[1:], 0)
        == (setting.teacher, setting.student, setting.instruction_type, setting.feedback_type, setting.lessons)
    ]
    truthful, distorted = (share(mine, label, "claims") or 0.0 for label in (Label.TRUTHFUL, Label.DISTORTED))
    return ClaimShares(truthful, distorted)


def _surprise(data: Data, significant: Sequence[Primary]) -> Surprise | None:
    """The largest surprise."""
    found = []
    for each in significant:
        one, other = said(data, each.compared.teacher, each), said(data, data.study.baseline, each)
        expected = one.worth - other.worth
        if abs(expected) < _ALIKE or expected * each.mean < 0:
            found.append(Surprise(each, one, other))
    return max(found, key=lambda surprise: abs(surprise.found.mean), default=None)


def _needed(primary: Sequence[Primary], significant: Sequence[Primary]) -> Needed | None:
    still = [each for each in primary if each not in significant]
    more = {i: seeds for i, each in enumerate(still) if (seeds := each.more(len(primary))) is not None}
    if not more:
        return None
    nearest = min(more, key=lambda i: more[i])
    return Needed(len(still), still[nearest], more[nearest], max(more.values()))


def _plot(data: Data, found: Sequence[Primary]) -> Plot:
    called, typed = data.called, _typed(found)

    def series(each: Primary) -> str:
        name = called(each.compared.student)
        return f"{name} ({type_words(each.compared.instruction_type, each.compared.feedback_type)})" if typed else name

    teachers = [teacher for teacher in data.study.teachers if any(teacher == each.compared.teacher for each in found)]
    teachers.sort(key=lambda t: -max(each.mean for each in found if each.compared.teacher == t))
    baseline = called(data.study.baseline)
    return Plot(
        name="findings-scores",
        title=f"Score of each teacher against {baseline} with each student, over all families.",
        draw=lambda width: gain_plot(
            [called(teacher) for teacher in teachers],
            list(dict.fromkeys(map(series, found))),
            {(called(each.compared.teacher), series(each)): each.score.estimate for each in found},
            {(called(each.compared.teacher), series(each)): each.shares for each in found},
            baseline,
            width,
        ),
        columns=(
            *("teacher", "student", "instruction_type", "feedback_type", "primary", "where", "seeds"),
            *("score", "score_low", "score_high", "p"),
        ),
        rows=[
            row
            for each in found
            for row in (
                (
                    *(*each.compared, each.declared, "all", each.score.estimate.n, *each.score.estimate[:3]),
                    each.score.p if data.test else "",
                ),
                *(
                    (*each.compared, each.declared, group.family, "", score, "", "", "")
                    for group, score in zip(each.families, each.shares, strict=True)
                ),
            )
        ],
    )


def _plots(data: Data) -> list[Plot]:
    return [_plot(data, data.compared)] if data.primary else []


PART = Part("findings", _values, "Findings", plots=_plots)
