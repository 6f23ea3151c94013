"""What is said about poems, each checked by offering poems to the world."""

from collections.abc import Sequence
from functools import lru_cache

from teachers.atoms import FN, FP, HN, HP, Claim, Grounded, Moment, claim
from worlds.poem import HAIKU, MAX_LENGTH, TANKA, Truth, compose, lines_of
from worlds.world import World

PLACEHOLDER = "..."
"""Stands for a line that is still to be written: a line without syllables, so a wrong one."""
TITLES = {HAIKU: "haiku", TANKA: "tanka"}
"""What poems of a form are called."""
TOLD = 20
"""A poem can have thousands of lines; feedback does not speak of more than these."""


@claim
class Goal(Claim):
    """True if the poem, of this form, must have this pattern: so many lines with so many syllables each."""

    form: str
    lines: int
    pattern: tuple[int, ...]
    listing: str
    """The pattern in words, such as `5, 7 and 5`."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer a poem of this pattern, and others with a syllable or a line too many, or a line too few."""
        drum = [_drum(number) for number in self.pattern]
        wrong = [[_drum(n + (i == j)) for j, n in enumerate(self.pattern)] for i in range(len(self.pattern))]
        return (
            self.form == TITLES.get(lab.form, "poem")
            and self.lines == len(self.pattern)
            and self.listing == listing_of(self.pattern)
            and _solves(lab, moment.after, drum)
            and not any(_solves(lab, moment.after, lines) for lines in (*wrong, [*drum, drum[-1]], drum[:-1]))
        )


@claim
class FreeGoal(Claim):
    """True if every line must have `syllables` syllables, in a poem of any number of lines from one up."""

    syllables: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer poems of several lengths, and others with a syllable too many or without a line."""
        right, wrong = _drum(self.syllables), _drum(self.syllables + 1)
        return all(_solves(lab, moment.after, [right] * lines) for lines in (1, 2, 3, 30)) and not any(
            _solves(lab, moment.after, lines) for lines in ([], [wrong], [right, wrong])
        )


@claim
class Counting(Claim):
    """True if a word may be read with any pronunciation of CMUdict, and is estimated where it is not listed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer `fire`, which is listed with one and with two syllables, and a word that nobody listed."""
        return _plays(lab, "fire", 1) and _plays(lab, "fire", 2) and _plays(lab, "glimmerfoam", 3)


@claim
class Answer(Claim):
    """True if lines of verse are lines of text, blank lines do not count, and so many characters are allowed."""

    limit: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer two lines with and without a blank one between them, and as one; and texts about the limit."""
        two = Truth((1, 1), False, "")
        return (
            _solves(lab, two, ["la", "la"])
            and _solves(lab, two, ["la", " ", "la"])
            and not _solves(lab, two, ["la la"])
            and lab.action_space.contains("x" * self.limit)
            and not lab.action_space.contains("x" * (self.limit + 1))
        )


@claim
class TriedWell(Claim):
    """True if `words` can be read with `syllables` syllables, which is what line `line` must have."""

    kind = HP
    words: str
    line: int
    syllables: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the line as a poem of its own."""
        return _required(moment.after, self.line) == self.syllables and _plays(lab, self.words, self.syllables)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return tuple(
            TriedInVain(words=self.words, line=self.line, counted=counted, required=self.syllables)
            for counted in _near(self.syllables)
        )


@claim
class TriedInVain(Claim):
    """True if `words` can be read with `counted` syllables but not with `required`, which line `line` must have."""

    kind = HN
    words: str
    line: int
    counted: int
    required: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the line as a poem of its own."""
        return (
            _required(moment.after, self.line) == self.required
            and _plays(lab, self.words, self.counted)
            and not _plays(lab, self.words, self.required)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(words=self.words, line=self.line, syllables=self.required),)


@claim
class Solution(Claim):
    """True if the poem `action` is right."""

    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it."""
        return _solves(lab, moment.after, [self.action])


@claim
class AllRight(Claim):
    """True if every line of the last poem can be read with the required number of syllables, and none is missing."""

    kind = HP

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the poem again."""
        return moment.before is not None and _solves(lab, moment.before, [moment.action])

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault with the first line."""
        return _faults(moment, 1)


@claim
class LinesRight(Claim):
    """True if each of these lines of the last poem can be read with its number of syllables.

    The lines of a poem with a wrong number of lines are neither right nor wrong.
    """

    kind = HP
    lines: tuple[int, ...]
    listing: str
    """The lines in words, such as `lines 1 and 3`."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer each line as a poem of its own."""
        return all(
            _judged(moment, line) and _plays(lab, _line(moment, line), _required(moment.before, line))
            for line in self.lines
        ) and self.listing == _lines_listing(self.lines)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise the other lines, or find fault with these."""
        others = tuple(i for i in range(1, len(lines_of(moment.action)) + 1) if i not in self.lines)[:TOLD]
        praise = (lines_right(others),) if others else ()
        return (*praise, *_faults(moment, self.lines[0]))


@claim
class WrongLine(Claim):
    """True if a line of the last poem can be read with `counted` syllables but not with `required`, as it must be."""

    kind = HN
    line: int
    counted: int
    required: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the line as a poem of its own."""
        if not _judged(moment, self.line) or self.required != _required(moment.before, self.line):
            return False
        words = _line(moment, self.line)
        return _plays(lab, words, self.counted) and not _plays(lab, words, self.required)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Count wrong, or praise the line."""
        counts = (n for n in _near(self.counted) if n != self.required)
        wrong = (WrongLine(line=self.line, counted=n, required=self.required) for n in counts)
        return (*wrong, lines_right((self.line,)))


@claim
class WrongNumber(Claim):
    """True if the last poem has `lines` lines, at least one, and must have `required`."""

    kind = HN
    lines: int
    required: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Count the lines that hold more than space, and ask for so many."""
        return (
            moment.before is not None
            and self.lines == sum(not line.isspace() for line in moment.action.splitlines() if line) > 0
            and not moment.before.free
            and self.required == len(moment.before.pattern) != self.lines
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Count the lines wrong."""
        others = (WrongNumber(lines=n, required=self.required) for n in _near(self.lines) if n and n != self.required)
        return (*others, AllRight())


@claim
class Empty(Claim):
    """True if the last poem has no line."""

    kind = HN

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look for a character that is not space."""
        return moment.before is not None and (not moment.action or moment.action.isspace())

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find lines in it."""
        required = len(moment.before.pattern)
        return WrongNumber(lines=required + 1, required=required), AllRight()


@claim
class Write(Claim):
    """True if the poem `action` earns more than the last one, and has as line `line` these words, which fit there."""

    kind = FP
    action: str
    line: int
    words: str
    syllables: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer both poems, and the line as a poem of its own."""
        lines = self.action.split("\n")
        return (
            1 <= self.line <= len(lines)
            and lines[self.line - 1] == self.words
            and _required(moment.after, self.line) == self.syllables
            and _plays(lab, self.words, self.syllables)
            and _pays(lab, moment.after, self.action) > _pays(lab, moment.after, moment.after.draft)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Miscount the syllables of the line."""
        lines = self.action.split("\n")
        return tuple(write_line(lines, self.line, self.syllables, wrong) for wrong in _near(self.syllables) if wrong)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The line to work on, then its number of syllables."""
        return Work.on(self, line=self.line), Count(line=self.line, syllables=self.syllables)


@claim
class Work(Grounded):
    """True if another line `line` can make a poem that earns more than the last one."""

    kind = FP
    line: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the poem that the ground knows."""
        return self.line == self._ground.line and self.stands(moment, lab)


@claim
class Count(Claim):
    """True if line `line` must have so many syllables."""

    kind = FP
    line: int
    syllables: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer a line with so many syllables where a line like that is asked for."""
        return _plays(lab, _drum(self.syllables), _required(moment.after, self.line))

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another number."""
        return tuple(Count(line=self.line, syllables=number) for number in _near(self.syllables) if number)


@claim
class Shorten(Claim):
    """True if `action`, which is the first `lines` lines of the last poem, is right and the last poem is not."""

    kind = FP
    action: str
    lines: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer both poems."""
        draft = moment.after.draft
        return (
            tuple(self.action.split("\n")) == lines_of(draft)[: self.lines]
            and self.lines == self.action.count("\n") + 1
            and _solves(lab, moment.after, [self.action])
            and not _solves(lab, moment.after, [draft])
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Cut it a line off the mark."""
        lines = lines_of(moment.after.draft)
        return tuple(Shorten(action="\n".join(lines[:n]), lines=n) for n in _near(self.lines) if 1 <= n <= len(lines))


@claim
class Repeat(Claim):
    """True if `action` is the last poem, and is right."""

    kind = FP
    action: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer it again."""
        return self.action == moment.after.draft and _solves(lab, moment.after, [self.action])

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Put a line in it that does not fit."""
        required = _required(moment.after, 1)
        lines = pliable_lines(lines_of(self.action), moment.after)
        return tuple(write_line(lines, 1, required, wrong) for wrong in _near(required) if wrong)


@claim
class AvoidCount(Claim):
    """True if line `line` must not be one of `counted` syllables: it must have another number of them."""

    kind = FN
    line: int
    counted: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer a line with the required number where a line of so many syllables is asked for."""
        return not _plays(lab, _drum(_required(moment.after, self.line)), self.counted)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the required number."""
        return (AvoidCount(line=self.line, counted=_required(moment.after, self.line)),)


@claim
class AvoidLines(Claim):
    """True if the poem must not have `lines` lines, at least one."""

    kind = FN
    lines: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer so many lines of one syllable where each line must have one: they must not earn anything."""
        truth = moment.after
        ones = Truth((1,) * len(truth.pattern), truth.free, "")
        return self.lines >= 1 and _pays(lab, ones, "\n".join("a" * self.lines)) == -1.0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the required number."""
        return (AvoidLines(lines=len(moment.after.pattern)),)


def _drum(syllables: int) -> str:
    """A line of so many syllables in which nothing else is likely to be wrong."""
    return " ".join(["la"] * syllables) or PLACEHOLDER


def _pays(lab: World, truth: Truth, poem: str) -> float:
    lab.restore(truth)
    return lab.step(poem)[1]


def _solves(lab: World, truth: Truth, lines: Sequence[str]) -> bool:
    lab.restore(truth)
    return lab.step("\n".join(lines))[4]["success"]


def _plays(lab: World, line: str, syllables: int) -> bool:
    """Whether a line alone is right where one line of so many syllables is required."""
    return _solves(lab, Truth((syllables,), False, ""), (line,))


def _required(truth: Truth, line: int) -> int:
    """Syllables that line `line` must have, counted from 1; 0 if there must be no such line."""
    if truth.free:
        return truth.pattern[0]
    return truth.pattern[line - 1] if 1 <= line <= len(truth.pattern) else 0


def _line(moment: Moment, line: int) -> str:
    return lines_of(moment.action)[line - 1]


def _judged(moment: Moment, line: int) -> bool:
    """Whether the last poem has this line and the right number of lines, so that the line is right or wrong."""
    if moment.before is None:
        return False
    lines = len(lines_of(moment.action))
    return 1 <= line <= lines and (moment.before.free or lines == len(moment.before.pattern))


def listing_of(items: Sequence[int]) -> str:
    """Numbers in words, such as `5, 7 and 5`."""
    return ", ".join(map(str, items[:-1])) + " and " * (len(items) > 1) + str(items[-1])


def _lines_listing(lines: tuple[int, ...]) -> str:
    return ("lines " if len(lines) > 1 else "line ") + listing_of(lines)


@lru_cache(maxsize=1024)
def lines_right(lines: tuple[int, ...]) -> LinesRight:
    """Praise of these lines."""
    return LinesRight(lines=lines, listing=_lines_listing(lines))


def _near(number: int) -> tuple[int, ...]:
    return tuple(n for n in (number - 1, number + 1, number - 2, number + 2) if n >= 0)


def _faults(moment: Moment, line: int) -> tuple[Claim, ...]:
    required = _required(moment.before, line)
    return tuple(WrongLine(line=line, counted=counted, required=required) for counted in _near(required))


def write_line(lines: Sequence[str], line: int, syllables: int, number: int) -> Write:
    """Advice to put a line of `number` syllables at a place where `syllables` are required."""
    words = compose(number, line)
    action = "\n".join((*lines[: line - 1], words, *lines[line:]))
    return Write(action=action, line=line, words=words, syllables=syllables)


def example_of(truth: Truth) -> tuple[str, ...]:
    """The lines of a poem that is right."""
    pattern = truth.pattern * _FREE_LINES if truth.free else truth.pattern
    return tuple(compose(number, line) for line, number in enumerate(pattern, 1))


def pliable_lines(lines: tuple[str, ...], truth: Truth) -> tuple[str, ...]:
    """The lines of the last poem, if there is room to edit it; else those of a poem that is right."""
    return lines if len(truth.draft) <= MAX_LENGTH - _ROOM else example_of(truth)


_FREE_LINES = 3
_ROOM = 500  # characters, more than any line that `compose` makes and the placeholders beside it take
