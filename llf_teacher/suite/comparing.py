"""Two cards beside each other: the difference of each ability's scores, by what the cards hold."""

from pathlib import Path
from typing import NamedTuple

from scipy import stats

from llf_teacher.studies.analysis.statistics import LEVEL, holm
from llf_teacher.suite.card import AbilityLine, Card, CardError, check, interval_words


class CardDifference(NamedTuple):
    """What the score of an ability on the second card differs by from that on the first."""

    name: str
    ability: str
    value: float | None
    """None where a card has no score."""
    low: float | None
    """Ends of the 95 % interval; None without one."""
    high: float | None
    p: float | None
    """That the scores are the same, after Holm's correction for all abilities that have an interval on both cards."""
    why: str
    """Why a value or an interval is missing."""

    @property
    def words(self) -> str:
        """The difference as text."""
        return interval_words(self.value, self.low, self.high, self.why, "+")


def compare(first: Path | str, second: Path | str, digest: str) -> list[CardDifference]:
    """The second card's scores less the first one's, for abilities on both.

    The tests are Welch's (1947), whose standard errors are those of the cards' intervals. They take the scores as
    independent. In the same worlds scores mostly vary together, and then a difference is more certain than is said.

    Raises:
        CardError: a file is no card of this suite, only one is quick, or they have no ability in common.
    """
    cards = check(first, digest), check(second, digest)
    if cards[0].quick != cards[1].quick:
        quick, full = (first, second) if cards[0].quick else (second, first)
        raise CardError(f"{quick} is of the quick suite, {full} is not: their scores cannot be compared")
    by_name = [{each.name: each for each in card.lines} for card in cards]
    pairs = [(one, by_name[1][name]) for name, one in by_name[0].items() if name in by_name[1]]
    if not pairs:
        raise CardError(f"{first} and {second} have no ability in common: {_names(cards[0])}; {_names(cards[1])}")
    found = [_difference(*pair) for pair in pairs]
    tested = [i for i, each in enumerate(found) if each.p is not None]
    for i, p in zip(tested, holm([found[i].p or 0.0 for i in tested]), strict=True):
        found[i] = found[i]._replace(p=p)
    return found


def _difference(first: AbilityLine, second: AbilityLine) -> CardDifference:
    lines = {"first card": first, "second card": second}
    difference = CardDifference(first.name, first.ability, None, None, None, None, "")
    if first.score is None or second.score is None:
        return difference._replace(why=next(f"{of}: {each.why}" for of, each in lines.items() if each.score is None))
    difference = difference._replace(value=(value := second.score - first.score))
    if first.low is None or second.low is None:
        return difference._replace(why=next(f"{of}: {each.why}" for of, each in lines.items() if each.low is None))
    squares = [_error(line) ** 2 for line in (first, second)]
    whole = sum(squares)
    if not whole:  # neither score varies
        return difference._replace(low=value, high=value, p=float(value == 0))
    freedom = whole**2 / sum(
        square**2 / (line.seeds - 1) for square, line in zip(squares, (first, second), strict=True)
    )
    half = float(stats.t.ppf((1 + LEVEL) / 2, freedom)) * whole**0.5
    p = float(2 * stats.t.sf(abs(value) / whole**0.5, freedom))
    return difference._replace(low=value - half, high=value + half, p=p)


def _error(line: AbilityLine) -> float:
    """The standard error of a score, from its interval, which is Student's."""
    assert line.low is not None and line.high is not None  # noqa: S101, PT018  # for the types
    return float((line.high - line.low) / 2 / stats.t.ppf((1 + LEVEL) / 2, line.seeds - 1))


def _names(card: Card) -> str:
    return ", ".join(each.name for each in card.lines)
