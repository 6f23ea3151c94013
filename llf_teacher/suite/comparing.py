"""Reading cards of this release, and comparing two: the difference of each ability's scores."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from scipy import stats

from llf_teacher.studies.analysis.statistics import LEVEL
from llf_teacher.suite import taking
from llf_teacher.suite.card import AbilityLine, Card, CardError, adjusted
from llf_teacher.suite.experiment import all_experiments
from teachers.spec import unknown


@dataclass(frozen=True, kw_only=True)
class CardDifference(AbilityLine):
    """The score of an ability on the second card minus the score on the first."""

    sign = "+"


def check(path: Path | str) -> Card:
    """The card in a file, if it is complete and of this version of the suite.

    Raises:
        CardError: the file is not a card, was changed, or belongs to something else.
    """
    card = Card.load(path)
    if card.suite != taking.VERSION:
        raise CardError(f"{path}: {unknown('suite', card.suite, [taking.VERSION])}")
    if card.digest != taking.digest():
        raise CardError(
            f"{path} has the digest {card.digest}, this release {taking.digest()}: cannot be compared; take the suite "
            "again"
        )
    lines = [f"{name}: {each.ability}" for name, each in all_experiments().items()]
    if odd := [line for each in card.lines if (line := f"{each.name}: {each.ability}") not in lines]:
        raise CardError(f"{path}: {unknown('line', odd[0], lines)}")
    return card


def compare(first: Path | str, second: Path | str) -> list[CardDifference]:
    """The second card's scores minus the first one's, for common abilities.

    The tests are Welch's (1947), with standard errors from the cards' intervals. They assume independent scores; scores
    in the same worlds mostly vary together, and then the tests are conservative. If neither score varies, `p` is the
    least p-value of sign flips over the smaller number of seeds.

    Raises:
        CardError: a file is not a card of this release, only one is quick, or they have no ability in common.
    """
    cards = check(first), check(second)
    if cards[0].quick != cards[1].quick:
        quick, full = (first, second) if cards[0].quick else (second, first)
        raise CardError(f"{quick} is of the quick suite, {full} is not: their scores cannot be compared")
    by_name = [{each.name: each for each in card.lines} for card in cards]
    found = [_difference(one, by_name[1][name]) for name, one in by_name[0].items() if name in by_name[1]]
    if not found:
        both = "; ".join(", ".join(names) for names in by_name)
        raise CardError(f"{first} and {second} have no ability in common: {both}")
    p = adjusted([each.p for each in found])
    return [replace(each, p=own) for each, own in zip(found, p, strict=True)]


def _difference(first: AbilityLine, second: AbilityLine) -> CardDifference:
    found = partial(CardDifference, name=first.name, ability=first.ability)
    value, measured = (second.score or 0) - (first.score or 0), None not in (first.score, second.score)
    parts = []
    for of, line in (("first", first), ("second", second)):
        if line.score is None or (measured and line.low is None):
            return found(score=value if measured else None, why=f"{of} card: {line.why}")
        half = ((line.high or 0) - (line.low or 0)) / 2  # Student's
        parts.append(((half / stats.t.ppf((1 + LEVEL) / 2, line.seeds - 1)) ** 2, line.seeds - 1))
    whole = sum(square for square, _ in parts)
    if not whole:  # neither score varies
        least = 2.0 ** (1 - min(first.seeds, second.seeds))
        return found(score=value, low=value, high=value, p=least if value else 1.0)
    freedom = whole**2 / sum(square**2 / free for square, free in parts)
    half = float(stats.t.ppf((1 + LEVEL) / 2, freedom)) * whole**0.5
    p = float(2 * stats.t.sf(abs(value) / whole**0.5, freedom))
    return found(score=value, low=value - half, high=value + half, p=p)
