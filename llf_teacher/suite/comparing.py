"""Two cards beside each other: the difference of each ability's scores, by what the cards hold."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from scipy import stats

from llf_teacher.studies.analysis.statistics import LEVEL, holm
from llf_teacher.suite import VERSION, all_experiments, mirror
from llf_teacher.suite.card import AbilityLine, Card, CardError, ScoreLine, check
from teachers.spec import unknown


@dataclass(frozen=True, kw_only=True)
class CardDifference(ScoreLine):
    """What the score of an ability on the second card differs by from that on the first."""

    sign = "+"


def compare(first: Path | str, second: Path | str, digest: str) -> list[CardDifference]:
    """The second card's scores less the first one's, for abilities on both.

    The tests are Welch's (1947), whose standard errors are those of the cards' intervals. They take the scores as
    independent. In the same worlds scores mostly vary together, and then a difference is more certain than is said.

    Raises:
        CardError: a file is no card of this suite, only one is quick, or they have no ability in common.
    """
    cards = checked(first, digest), checked(second, digest)
    if cards[0].quick != cards[1].quick:
        quick, full = (first, second) if cards[0].quick else (second, first)
        raise CardError(f"{quick} is of the quick suite, {full} is not: their scores cannot be compared")
    by_name = [{each.name: each for each in card.lines} for card in cards]
    pairs = [(one, by_name[1][name]) for name, one in by_name[0].items() if name in by_name[1]]
    if not pairs:
        both = "; ".join(", ".join(each.name for each in card.lines) for card in cards)
        raise CardError(f"{first} and {second} have no ability in common: {both}")
    found = [_difference(*pair) for pair in pairs]
    tested = [i for i, each in enumerate(found) if each.p is not None]
    for i, p in zip(tested, holm([found[i].p or 0.0 for i in tested]), strict=True):
        found[i] = replace(found[i], p=p)
    return found


def checked(path: Path | str, digest: str) -> Card:
    """The card in a file, if it is whole, of this suite, and of abilities of the suite alone.

    Raises:
        CardError: it is not, see `llf_teacher.suite.check`.
    """
    card, known = check(path, digest), dict[str, list[str]]()
    known[VERSION] = [f"{name}: {each.ability}" for name, each in all_experiments().items()]
    known[mirror.VERSION] = [f"{name}: {each.ability}" for name, each in mirror.all_qualities().items()]
    if card.suite not in known:
        raise CardError(f"{path}: {unknown('suite', card.suite, known)}")
    for line in (f"{each.name}: {each.ability}" for each in card.lines):
        if line not in known[card.suite]:
            raise CardError(f"{path}: {unknown('line', line, known[card.suite])}")
    return card


def _difference(first: AbilityLine, second: AbilityLine) -> CardDifference:
    lines = {"first card": first, "second card": second}
    found = partial(CardDifference, name=first.name, ability=first.ability)
    if first.score is None or second.score is None:
        why = next(f"{of}: {each.why}" for of, each in lines.items() if each.score is None)
        return found(score=None, why=why)
    value = second.score - first.score
    if first.low is None or second.low is None:
        return found(score=value, why=next(f"{of}: {each.why}" for of, each in lines.items() if each.low is None))
    parts = [(_error(line) ** 2, line.seeds - 1) for line in (first, second)]
    whole = sum(square for square, _ in parts)
    if not whole:  # neither score varies
        return found(score=value, low=value, high=value, p=float(value == 0))
    freedom = whole**2 / sum(square**2 / free for square, free in parts)
    half = float(stats.t.ppf((1 + LEVEL) / 2, freedom)) * whole**0.5
    p = float(2 * stats.t.sf(abs(value) / whole**0.5, freedom))
    return found(score=value, low=value - half, high=value + half, p=p)


def _error(line: AbilityLine) -> float:
    """The standard error of a score, from its interval, which is Student's."""
    assert line.low is not None and line.high is not None  # noqa: S101, PT018  # for the types
    return float((line.high - line.low) / 2 / stats.t.ppf((1 + LEVEL) / 2, line.seeds - 1))
