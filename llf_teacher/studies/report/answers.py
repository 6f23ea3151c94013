"""The answers of a report: a sentence for each comparison that the study asks about, own teachers before others."""

from typing import NamedTuple

from llf_teacher.studies.analysis.evidence import Evidence, PairEvidence, finding, is_small
from llf_teacher.studies.analysis.primary import Primary
from llf_teacher.studies.analysis.scores import pairs
from llf_teacher.studies.analysis.statistics import Estimate, p_words
from llf_teacher.studies.definition.stored_specs import is_own
from llf_teacher.studies.report.data import Data
from teachers.words import listed, type_words

MOST = 3
"""The greatest number of answers of a study that asks no question; of one that asks, all are given."""


class PairAnswer(NamedTuple):
    """What a study says about two teachers of a student."""

    about: Primary
    finding: PairEvidence
    text: str
    """One or two sentences, with number, interval, n, and whether it is evidence."""


def answers(data: Data) -> list[PairAnswer]:
    """The answers, in the order of `Study.compare`, or with a user's own teachers and students first."""
    primary = data.primary
    if not data.study.compare:
        primary = sorted(primary, key=_own_first)[:MOST]
    there = pairs(data.taught, data.study.baseline, data.study.compare)
    found = []
    for each in primary:
        said = finding(each, len(data.primary), data.test, there)
        found.append(PairAnswer(each, said, _text(data, each, said)))
    return found


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
    elif said.against and said.evidence is Evidence.YES:
        head = f"{head}, but {'more' if way == 'less' else 'less'} in {listed(said.against, 'and')}"
    return f"{head}: {_numbers(data, each)}. {_verdict(data, each, said)}{_by_family(data, each)}"


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
        return f"Is this evidence of a difference? Yes{small}."
    if said.evidence is Evidence.OPEN:
        played = f": {data.present} of {data.expected} episodes have been played, and" if data.test is None else ":"
        return f"Is this evidence of a difference? Not decided{played} {said.why}."
    if each.score.estimate.why:
        return "Is this evidence of a difference? No: the regret is the same in every seed."
    return f"Is this evidence of a difference? No: {excluded}."


def _by_family(data: Data, each: Primary) -> str:
    """The differences of several families, and why there is no score."""
    lacking = [group.family for group, ratio in zip(each.families, each.ratios, strict=True) if not ratio]
    text = ""
    if len(each.families) > 1:
        every = [
            f"{group.family} {_difference(difference, data.units[group.family], regrets)}"
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


def _difference(difference: Estimate, unit: str, regrets: tuple[float, float]) -> str:
    greatest = max(map(abs, regrets))
    digits = 4 if greatest < 0.1 else 1 if greatest >= 10 and abs(difference.mean) >= 0.1 else 2
    one, other = (number(regret, digits) for regret in regrets)
    return f"{number(difference.mean, digits, sign=True)}{_interval(difference, digits)} {unit} ({one} against {other})"


def _interval(estimate: Estimate, digits: int = 2) -> str:
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


def number(value: float, digits: int = 2, *, sign: bool = False) -> str:
    """A number with a typographic minus sign, and no sign at zero unless there is a plus."""
    text = f"{value:{'+' if sign else ''}.{digits}f}"
    return text.lstrip("+-") if float(text) == 0 else text.replace("-", "\N{MINUS SIGN}")
