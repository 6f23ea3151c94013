"""The answers of a report: a sentence for each comparison that the study asks about, own teachers before others."""

from typing import NamedTuple, cast

import numpy as np

from llf_teacher.studies.analysis.evidence import Evidence, PairEvidence, finding, is_small
from llf_teacher.studies.analysis.primary import Primary
from llf_teacher.studies.analysis.scores import pairs
from llf_teacher.studies.analysis.statistics import Estimate, p_words
from llf_teacher.studies.definition.stored_specs import is_own, teacher_of
from llf_teacher.studies.report.data import Data
from llf_teacher.studies.report.said import episode_counts
from teachers.words import listed, type_words

MOST = 3
"""The greatest number of answers of a study that asks no question; of one that asks, all are given."""

_FEW = 0.5  # a smaller number of claims in an episode is not worth a sentence
_NAMED = 2  # families that are named each; of more the mean is said
_TINY, _GREAT = 0.01, 1e6
"""Regrets below the first or from the second on have significant digits: fixed ones would show none or too many."""


class PairAnswer(NamedTuple):
    """What a study says about two teachers of a student."""

    about: Primary | None
    """The comparison; None if the study asks for it and there is none."""
    finding: PairEvidence | None
    """What the data say; None without a comparison."""
    text: str
    """One or two sentences, with number, interval, n, and whether it is evidence."""


def answers(data: Data) -> list[PairAnswer]:
    """The answers, in the order of `Study.compare`, or with a user's own teachers and students first."""
    found = [PairAnswer(each, said, _text(data, each, said)) for each, said in evidence(data)]
    if not data.study.compare:
        return sorted(found, key=lambda each: _own_first(cast(Primary, each.about)))[:MOST]
    asked: dict[tuple[str, ...], list[PairAnswer]] = {pair: [] for pair in map(tuple, data.study.compare)}
    for each in found:
        compared = cast(Primary, each.about).compared
        asked[compared.teacher, compared.other].append(each)
    return [
        each
        for pair, mine in asked.items()
        for each in mine or [PairAnswer(None, None, _nothing(data, *map(data.called, pair)))]
    ]


def evidence(data: Data) -> list[tuple[Primary, PairEvidence]]:
    """What the data say about each primary comparison."""
    there = pairs(data.taught, data.study.baseline, data.study.compare)
    return [(each, finding(each, len(data.primary), data.test, there)) for each in data.primary]


def _nothing(data: Data, one: str, other: str) -> str:
    """Why two teachers that the study compares have no comparison."""
    head = f"Nothing can be said about {one} and {other}"
    if data.present < data.expected:
        return f"{head}: no student that reads what teachers say was taught by both on the same seeds. {_played(data)}."
    return (
        f"{head}: no student of this study can hear a difference, since it does not read what teachers say, there is "
        "no feedback, or both teachers are silent."
    )


def _played(data: Data) -> str:
    lost = sum(data.failures.values())
    return f"{data.present} of {data.expected} episodes have been played{f', {lost} failed' if lost else ''}"


def _own_first(each: Primary) -> tuple[bool, bool]:
    return not is_own(each.compared.teacher), not is_own(each.compared.student)


def _text(data: Data, each: Primary, said: PairEvidence) -> str:
    called, compared = data.called, each.compared
    one, other, student = called(compared.teacher), called(compared.other), called(compared.student)
    typed = len({(p.compared.instruction_type, p.compared.feedback_type) for p in data.primary}) > 1
    types = f" ({type_words(compared.instruction_type, compared.feedback_type)})" if typed else ""
    way = "less" if each.mean > 0 else "more"
    over = f"Over {len(each.families)} families " if len(each.families) > 1 else ""
    if said.evidence is Evidence.YES:
        head = f"{over}{student}{types} loses {way} with {one} than with {other}"
    elif said.evidence is Evidence.NO:
        head = f"{over}{student}{types} loses as much with {one} as with {other}"
    else:
        over = f", {over.strip().lower()}," if over else ""
        head = f"Whether {student}{types} loses more with {one} or with {other}{over} is not decided"
    if said.against and said.along:
        head = f"It depends on the family: {_both_ways(each, said, one, other)}. {head}"
    elif said.evidence is not Evidence.YES and (said.against or said.along):
        where = listed(said.against or said.along, "and")
        head = f"{head}, but it loses {'less' if said.against else 'more'} with {one} in {where}"
    elif said.against:
        head = f"{head}, but {'more' if way == 'less' else 'less'} in {listed(said.against, 'and')}"
    elif 0 < len(said.along) < len(each.families):
        head = f"{head}, by itself significantly in {listed(said.along, 'and')} only"
    return f"{head}: {_numbers(data, each)}. {_verdict(data, each, said)}{_by_family(data, each)}{_said(data, each)}"


def _both_ways(each: Primary, said: PairEvidence, one: str, other: str) -> str:
    """Which teacher costs more where."""
    more, less = (
        (said.against, said.along) if said.evidence is Evidence.YES and each.mean > 0 else (said.along, said.against)
    )
    return f"{one} costs more in {listed(more, 'and')}, {other} in {listed(less, 'and')}"


def _numbers(data: Data, each: Primary) -> str:
    """The difference with its interval in the family's unit, its score, and n."""
    estimate, parts = each.score.estimate, []
    if len(each.families) == 1:
        (family,), (regrets,) = each.families, each.regrets
        parts.append(f"{_difference(each.differences[0], data.units[family.family], regrets)} in {family.family}")
    if each.ratio:
        parts.append(f"score {number(each.mean)}{_interval(estimate)}{beyond(estimate)}")
    seeds = f"n = {estimate.n} seed{'' if estimate.n == 1 else 's'}"
    return ", ".join([*parts, seeds, *([f"p {_p(each.score.p)}"] if data.test else [])])


def _verdict(data: Data, each: Primary, said: PairEvidence) -> str:
    mean = " on average over the families" if len(each.families) > 1 else ""
    excluded = f"the data exclude that one costs 22 % more than the other{mean}"
    if said.evidence is Evidence.YES:
        small = f", of a small one: {excluded}" if each.ratio and is_small(each.score.estimate) else ""
        if each.score.estimate.why:
            small += f", by p alone: the sign-flip test needs no interval{_by_share(each)}"
        return f"Is this evidence of a difference? Yes{small}."
    if said.evidence is Evidence.OPEN:
        played = f": {_played(data)}, and" if data.test is None else ":"
        return f"Is this evidence of a difference? Not decided{played} {said.why}."
    if each.score.estimate.why:
        return "Is this evidence of a difference? No: the regret is the same in every seed."
    return f"Is this evidence of a difference? No: {excluded}."


def _by_share(each: Primary) -> str:
    """The score of each of several families."""
    if len(each.families) < 2 or not each.ratio:
        return ""
    every = (f"{group.family} {number(share)}" for group, share in zip(each.families, each.shares, strict=True))
    return f"; score by family: {', '.join(every)}"


def _said(data: Data, each: Primary) -> str:
    """What both teachers said an episode in the families in which it differs much, or means; empty if one is mute."""
    if teacher_of(each.compared.teacher).mute or teacher_of(each.compared.other).mute:
        return ""
    counts = {
        group.family: [episode_counts(data, name, each.compared, group.family) for name in each.compared[::4]]
        for group in each.families
    }
    parts = []
    for place, word in enumerate(("false", "true and timely")):
        both = {family: (one[place], other[place]) for family, (one, other) in counts.items()}
        unlike = {family: pair for family, pair in both.items() if _unlike(*pair)}
        if len(unlike) > _NAMED:
            means = (number(float(np.mean(side)), 1) for side in zip(*unlike.values(), strict=True))
            where = [f"{' against '.join(means)} on average in {len(unlike)} of {len(both)} families"]
        else:
            where = [f"{number(one, 1)} against {number(other, 1)} in {name}" for name, (one, other) in unlike.items()]
        parts += [f"{word} claims {', '.join(where)}"] * bool(where)
    return f" Said in an episode: {'; '.join(parts)}." if parts else ""


def _unlike(one: float, other: float) -> bool:
    """Whether one number of claims in an episode is at least twice the other."""
    return max(one, other) >= _FEW and min(one, other) <= max(one, other) / 2


def _by_family(data: Data, each: Primary) -> str:
    """The differences of several families, and why there is no score."""
    lacking = [group.family for group, ratio in zip(each.families, each.ratios, strict=True) if not ratio]
    text = ""
    if len(each.families) > 1:
        every = [
            f"{group.family} {_difference(difference, data.units[group.family], regrets)}"
            + (f", n = {difference.n}" if difference.n < each.score.estimate.n else "")
            for group, difference, regrets in zip(each.families, each.differences, each.regrets, strict=True)
        ]
        one, other = map(data.called, (each.compared.teacher, each.compared.other))
        text += f" Regret with {one} minus that with {other}, by family: {'; '.join(every)}."
    if lacking:
        where = f" in {listed(lacking, 'and')}" if len(each.families) > 1 else ""
        names = map(data.called, (each.compared.other, each.compared.teacher))
        text += (
            " There is no score, since regret with {} is not well away from 0 beside that with {}".format(*names)
            + f"{where}."
        )
    return text


def result(data: Data, each: Primary) -> str:
    """A comparison in numbers: the score, or the difference in a single family's unit if there is no score; p and n."""
    estimate, parts = each.score.estimate, []
    if each.ratio:
        parts.append(f"score {number(each.mean)}{_interval(estimate)}")
    elif len(each.families) == 1:
        (family,), (regrets,) = each.families, each.regrets
        parts.append(_difference(each.differences[0], data.units[family.family], regrets))
    return ", ".join([*parts, *([f"p {_p(each.score.p)}"] if data.test else []), f"n = {estimate.n}"])


def _difference(difference: Estimate, unit: str, regrets: tuple[float, float]) -> str:
    greatest = max(map(abs, regrets))
    digits: int | None = 4 if greatest < 0.1 else 1 if greatest >= 10 and abs(difference.mean) >= 0.1 else 2
    if 0 < greatest < _TINY or greatest >= _GREAT:
        digits = None
    one, other = (number(regret, digits) for regret in regrets)
    return f"{number(difference.mean, digits, sign=True)}{_interval(difference, digits)} {unit} ({one} against {other})"


def _interval(estimate: Estimate, digits: int | None = 2) -> str:
    if estimate.why:
        return f" (no interval: {estimate.why})"
    return f" [{number(estimate.low, digits)}, {number(estimate.high, digits)}]"


def beyond(estimate: Estimate) -> str:
    """A remark where the interval of a score leaves the scale from -1 to 1."""
    leaves = not estimate.why and (estimate.low < -1 or estimate.high > 1)
    return " (beyond 1, since the interval takes the sum of both mean regrets as known)" if leaves else ""


def _p(p: float) -> str:
    words = p_words(p)
    return words if words.startswith("<") else f"= {words}"


def number(value: float, digits: int | None = 2, *, sign: bool = False) -> str:
    """A number with a typographic minus sign, and no sign at zero; without digits, with three significant ones."""
    text = f"{value:{'+' if sign else ''}{'.3g' if digits is None else f'.{digits}f'}}"
    return text.lstrip("+-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")
