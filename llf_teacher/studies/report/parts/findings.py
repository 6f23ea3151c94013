"""The findings of a study: its answers, its primary test, the largest contradiction, and the seeds still needed.

A difference is a contradiction if it does not fit what the teachers say: the teacher that makes more true, timely
claims a turn, less the false ones, should be better. So a teacher that says less and saves less is no contradiction.
Teachers that make as many may differ by when they make them.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from llf_teacher.studies.analysis.evidence import Evidence
from llf_teacher.studies.analysis.primary import Primary, enough, least
from llf_teacher.studies.definition.stored_specs import is_own, teacher_of
from llf_teacher.studies.report.answers import answers, beyond, evidence, result
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.report.parts.part import Part
from llf_teacher.studies.report.plots import Pane, gain_plot, panel_plot
from llf_teacher.studies.report.said import ClaimRates, turn_rates
from teachers.words import type_words

_DECLARED = ("question", "compare", "primary", "baseline", "seeds", "interim_analyses")
_LISTS = ("ids", "teachers", "students", "instruction_types", "feedback_types")
_ALIKE = 0.1  # a smaller difference, as a share of the greater number of claims, gives no expectation


class Surprise(NamedTuple):
    """A significant comparison that contradicts what the teachers say."""

    found: Primary
    teacher: ClaimRates
    baseline: ClaimRates


class Needed(NamedTuple):
    """The additional seeds that comparisons need for a power of 80 % at the observed differences."""

    open: int
    """Number of comparisons that are not decided."""
    nearest: Primary
    """The comparison that needs the fewest seeds."""
    fewest: int
    all: int
    """Seeds for every open comparison with an observed difference."""


class Later(NamedTuple):
    """What a study changed about its comparisons after episodes that it shows had been played."""

    names: tuple[str, ...]
    """Fields of the study."""
    episodes: int
    """Number of these episodes."""


class Tally(NamedTuple):
    """Number of primary comparisons, of significant ones, of those with evidence of no difference, and of the rest."""

    all: int
    better: int
    worse: int
    alike: int
    open: int


def _values(data: Data) -> Mapping[str, Any]:
    primary = data.primary
    if not primary:
        return {"missing": _missing(data), "answers": [each.text for each in answers(data)]}
    significant = data.significant
    undecided = [each for each, said in evidence(data) if said.evidence is Evidence.OPEN]
    lowest = least(primary, data.test) if data.test else 0.0
    return {
        "missing": "",
        "answers": [each.text for each in answers(data)],
        "baseline": data.study.baseline,
        "beside": any(each.compared.other == data.study.baseline for each in data.compared),
        "named_others": any(each.compared.other != data.study.baseline for each in data.compared),
        "scores": _scores(data),
        "differences": _differences(data),
        "without": [each for each in data.compared if not each.ratio],
        "beyond": any(beyond(each.score.estimate) for each in data.compared if each.ratio),
        "seeds": max(each.score.estimate.n for each in primary),
        "families": len({group.family for each in primary for group in each.families}),
        "typed": _typed(primary),
        "least": lowest if data.test and lowest > data.test.level else None,
        "enough": enough(len(primary)),
        "tested": _tally(primary, significant, undecided) if data.test else None,
        "largest": _largest(significant),
        "surprise": _surprise(data, significant),
        "needed": _needed(primary, undecided),
        "result": lambda each: result(data, each),
        "exploratory": len(data.compared) - len(primary),
        "later": _later(data),
        "wordless": _wordless(data),
    }


def _later(data: Data) -> Later | None:
    """What was changed with data at hand: p-values take the comparisons and the number of seeds as chosen before.

    Teachers, students and environments count that were left out afterwards, not those that came in addition.
    """
    study, definitions = data.study.as_dict(), data.store.definitions()
    names: dict[str, None] = {}
    episodes = 0
    for revision, count in data.revisions.items():
        before = definitions.get(revision, {}).get("study", {})
        differing = [name for name in _DECLARED if name in before and before[name] != study[name]]
        differing += [name for name in _LISTS if not set(before.get(name) or ()) <= set(study[name])]
        if differing and count.shown:
            names |= dict.fromkeys(differing)
            episodes += count.shown
    return Later(tuple(names), episodes) if names else None


def _wordless(data: Data) -> list[str]:
    """The teachers that said nothing though they are not mute, such as one that looks for a kind that there is not."""
    said: dict[str, float] = {}
    for setting, each in data.sums.items():
        if not setting.lessons and setting.feedback_type != "n":
            said[setting.teacher] = said.get(setting.teacher, 0) + each.sums["claims"] + each.sums["unchecked"]
    return [teacher for teacher, number in said.items() if not number and not teacher_of(teacher).mute]


def _missing(data: Data) -> str:
    """Why there is no comparison."""
    if data.study.baseline not in data.study.teachers and not data.study.compare:
        return "baseline"
    return "pairs" if data.present < data.expected else "hearing"


def _typed(found: Sequence[Primary]) -> bool:
    return len({(each.compared.instruction_type, each.compared.feedback_type) for each in found}) > 1


def _tally(primary: Sequence[Primary], significant: Sequence[Primary], undecided: Sequence[Primary]) -> Tally:
    better = sum(each.mean > 0 for each in significant)
    alike = len(primary) - len(significant) - len(undecided)
    return Tally(len(primary), better, len(significant) - better, alike, len(undecided))


def _largest(found: Sequence[Primary]) -> Primary | None:
    """The comparison with the largest difference: by the score, or in the unit of the family that all have alone.

    None if there are no comparisons, or several families and no score.
    """
    families = {each.families for each in found}
    if len(families) == 1 and len(found[0].families) == 1 and not all(each.ratio for each in found):
        return max(found, key=lambda each: abs(each.differences[0].mean))
    return max((each for each in found if each.ratio), key=lambda each: abs(each.mean), default=None)


def _surprise(data: Data, significant: Sequence[Primary]) -> Surprise | None:
    """The largest surprise."""
    found = []
    for each in significant:
        one, other = (turn_rates(data, name, each.compared) for name in (each.compared.teacher, each.compared.other))
        expected = one.worth - other.worth
        alike = abs(expected) <= _ALIKE * max(abs(one.worth), abs(other.worth))
        if not alike and expected * each.mean < 0:
            found.append(Surprise(each, one, other))
    largest = _largest([surprise.found for surprise in found])
    return next((surprise for surprise in found if surprise.found is largest), found[0] if found else None)


def _needed(primary: Sequence[Primary], undecided: Sequence[Primary]) -> Needed | None:
    more = {i: seeds for i, each in enumerate(undecided) if (seeds := each.more(len(primary))) is not None}
    if not more:
        return None
    nearest = min(more, key=lambda i: more[i])
    return Needed(len(undecided), undecided[nearest], more[nearest], max(more.values()))


def ranked(data: Data) -> list[Primary]:
    """The comparisons in the order of the study's question, then a user's own teachers, then as the study lists them.

    So reports of the same study with more episodes have the same order.
    """
    asked = [tuple(pair) for pair in data.study.compare]

    def rank(each: Primary) -> tuple[int, bool, int]:
        pair = each.compared.teacher, each.compared.other
        place = asked.index(pair) if pair in asked else len(asked)
        return place, not is_own(each.compared.teacher), data.study.teachers.index(each.compared.teacher)

    return sorted(data.compared, key=rank)


def arms(data: Data, each: Primary) -> str:
    """The teacher of a comparison, with the other one if that is not the baseline."""
    name, other = data.called(each.compared.teacher), each.compared.other
    return name if other == data.study.baseline else f"{name} against {data.called(other)}"


def _series(data: Data, each: Primary) -> str:
    name, types = data.called(each.compared.student), (each.compared.instruction_type, each.compared.feedback_type)
    return f"{name} ({type_words(*types)})" if _typed(data.compared) else name


def _labels(data: Data, found: Sequence[Primary]) -> tuple[list[str], list[str]]:
    """Rows and series of the figures; students in the order of the study, so that each keeps its colour."""
    order = list(data.study.students)
    students = sorted(found, key=lambda each: order.index(each.compared.student))
    return list(dict.fromkeys(arms(data, each) for each in found)), list(
        dict.fromkeys(_series(data, each) for each in students)
    )


def _fields(data: Data, each: Primary) -> tuple[Any, ...]:
    """The first columns of the figures' data."""
    called, compared = data.called, each.compared
    names = called(compared.teacher), called(compared.other), called(compared.student)
    return *names, compared.instruction_type, compared.feedback_type, each.declared


_FIELDS = ("teacher", "against", "student", "instruction_type", "feedback_type", "primary")


def _scores(data: Data) -> Plot | None:
    """The scores that have a meaning; None without any."""
    found = [each for each in ranked(data) if each.ratio]
    if not found:
        return None
    rows, _ = _labels(data, found)
    _, series = _labels(data, ranked(data))  # a student looks the same in both figures
    others = {each.compared.other for each in found}
    baseline = data.called(data.study.baseline) if data.study.baseline in others else ""
    baseline += ", or the teacher that is named" if baseline and len(others) > 1 else ""
    return Plot(
        name="findings-scores",
        title="Score of each teacher against another with each student, over all families.",
        draw=lambda width: gain_plot(
            rows,
            series,
            {(arms(data, each), _series(data, each)): each.score.estimate for each in found},
            {(arms(data, each), _series(data, each)): each.shares for each in found},
            baseline,
            width,
        ),
        columns=(*_FIELDS, "where", "seeds", "score", "score_low", "score_high", "p"),
        rows=[
            row
            for each in found
            for row in (
                (
                    *(*_fields(data, each), "all", each.score.estimate.n, *each.score.estimate[:3]),
                    each.score.p if data.test else "",
                ),
                *(
                    (*_fields(data, each), group.family, "", score, "", "", "")
                    for group, score in zip(each.families, each.shares, strict=True)
                ),
            )
        ],
    )


def _differences(data: Data) -> Plot:
    """Differences of regret in the families' units, a panel a family."""
    found = ranked(data)
    rows, series = _labels(data, found)
    every = [
        (group.family, each, difference, regrets)
        for each in found
        for group, difference, regrets in zip(each.families, each.differences, each.regrets, strict=True)
    ]
    return Plot(
        name="findings-differences",
        title="Regret with each teacher less that with another, by student, in each family's unit.",
        draw=lambda width: panel_plot(
            [
                Pane(
                    family,
                    data.units[family],
                    {
                        (arms(data, each), _series(data, each)): difference
                        for name, each, difference, _ in every
                        if name == family
                    },
                )
                for family in dict.fromkeys(name for name, *_ in every)
            ],
            rows,
            series,
            "more regret",
            width,
        ),
        columns=(*_FIELDS, "where", "unit", "seeds", "regret", "regret_against", "more", "more_low", "more_high"),
        rows=[
            (*_fields(data, each), family, data.units[family], difference.n, *regrets, *difference[:3])
            for family, each, difference, regrets in every
        ],
    )


def _plots(data: Data) -> list[Plot]:
    return [plot for plot in (_scores(data), _differences(data)) if plot is not None] if data.primary else []


PART = Part("findings", _values, "Findings", plots=_plots)
