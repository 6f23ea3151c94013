"""What the claims about poems are checked by: poems offered to the world, and numbers in words."""

from collections.abc import Sequence
from functools import lru_cache

from teachers.atoms import Moment
from worlds.poem import MAX_LENGTH, Poem, Truth, compose, lines_of

PLACEHOLDER = "..."
"""Stands for a line that is still to be written: a line without syllables, so a wrong one."""


def drum(syllables: int) -> str:
    """A line of so many syllables in which nothing else is likely to be wrong."""
    return " ".join(["la"] * syllables) or PLACEHOLDER


def pays(lab: Poem, truth: Truth, poem: str) -> float:
    """The reward that the world gives for a poem."""
    lab.restore(truth)
    return lab.step(poem)[1]


def solves(lab: Poem, truth: Truth, lines: Sequence[str]) -> bool:
    """Whether the world takes these lines for a poem that is right."""
    lab.restore(truth)
    return bool(lab.step("\n".join(lines))[4]["success"])


def plays(lab: Poem, line: str, syllables: int) -> bool:
    """Whether a line alone is right where one line of so many syllables is required."""
    return solves(lab, Truth((syllables,), False, ""), (line,))


def required_of(truth: Truth, line: int) -> int:
    """Syllables that line `line` must have, counted from 1; 0 if there must be no such line."""
    if truth.free:
        return truth.pattern[0]
    return truth.pattern[line - 1] if 1 <= line <= len(truth.pattern) else 0


def line_of(moment: Moment[Truth], line: int) -> str:
    """Line `line` of the last poem, counted from 1."""
    return lines_of(moment.action)[line - 1]


def judged(moment: Moment[Truth], line: int) -> bool:
    """Whether the last poem has this line and the right number of lines, so that the line is right or wrong."""
    if moment.before is None:
        return False
    lines = len(lines_of(moment.action))
    return 1 <= line <= lines and (moment.before.free or lines == len(moment.before.pattern))


@lru_cache(maxsize=1024)
def listing_of(items: tuple[int, ...]) -> str:
    """Numbers in words, such as `5, 7 and 5`."""
    return ", ".join(map(str, items[:-1])) + " and " * (len(items) > 1) + str(items[-1])


def numbered_lines(numbers: tuple[int, ...]) -> str:
    """The numbers of lines in words, such as `lines 1 and 3`."""
    return ("lines " if len(numbers) > 1 else "line ") + listing_of(numbers)


def near(number: int) -> tuple[int, ...]:
    """Counts that somebody might come to who counts wrong."""
    return tuple(n for n in (number - 1, number + 1, number - 2, number + 2) if n >= 0)


def syllables_of(count: int) -> str:
    """A number of syllables in words."""
    return "1 syllable" if count == 1 else f"{count} syllables"


def length_of(count: int) -> str:
    """A number of lines in words."""
    return "1 line" if count == 1 else f"{count} lines"


def example_of(truth: Truth) -> tuple[str, ...]:
    """The lines of a poem that is right."""
    pattern = truth.pattern * _FREE_LINES if truth.free else truth.pattern
    return tuple(compose(number, line) for line, number in enumerate(pattern, 1))


def editable(lines: tuple[str, ...], truth: Truth) -> tuple[str, ...]:
    """The lines of the last poem, if there is room to edit it; else those of a poem that is right."""
    return lines if len(truth.draft) <= MAX_LENGTH - _ROOM else example_of(truth)


_FREE_LINES = 3
_ROOM = 500  # characters, more than any line that `compose` makes and the placeholders beside it take
