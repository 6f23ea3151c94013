"""The claims about poems, each checked by offering poems to the lab."""

from collections.abc import Sequence
from typing import Annotated, Any

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    EditClaim,
    Grounded,
    Moment,
    Scope,
    Verdict,
    claim,
    opposed,
    slot,
)
from teachers.spec import Range
from worlds.poem import HAIKU, MAX_LENGTH, TANKA, Poem, Truth, compose, lines_of

Line = Annotated[int, Range(1, 99)]
"""The number of a line."""
PLACEHOLDER = "..."
"""A line still to be written: it has no syllables, so it is wrong."""


def filler(syllables: int) -> str:
    """A line of so many syllables that is unlikely to be wrong otherwise."""
    return " ".join(["la"] * syllables) or PLACEHOLDER


def pays(lab: Poem, truth: Truth, poem: str) -> float:
    """The reward that the world gives for a poem."""
    lab.restore(truth)
    return lab.step(poem)[1]


def solves(lab: Poem, truth: Truth, lines: Sequence[str]) -> bool:
    """Whether these lines are a right poem in the world."""
    lab.restore(truth)
    return bool(lab.step("\n".join(lines))[4]["success"])


def plays(lab: Poem, line: str, syllables: int) -> bool:
    """Whether a line is right as a poem of one line with so many syllables."""
    return solves(lab, Truth((syllables,), False, ""), (line,))


def required_of(truth: Truth, line: int) -> int:
    """The required syllables of line `line`, counted from 1; 0 if there must be no such line."""
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


def listing_of(items: tuple[int, ...]) -> str:
    """Numbers in words, such as `5, 7 and 5`."""
    return ", ".join(map(str, items[:-1])) + " and " * (len(items) > 1) + str(items[-1])


def numbered_lines(numbers: tuple[int, ...]) -> str:
    """The numbers of lines in words, such as `lines 1 and 3`."""
    return ("lines " if len(numbers) > 1 else "line ") + listing_of(numbers)


def near(number: int) -> tuple[int, ...]:
    """Numbers that a miscount might give."""
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
    """The lines of the last poem, or of a right poem if there is no room to edit it."""
    return lines if len(truth.draft) <= MAX_LENGTH - _ROOM else example_of(truth)


_FREE_LINES = 3
_ROOM = 500  # characters, more than any line that `compose` makes and the placeholders beside it take

TITLES = {HAIKU: "haiku", TANKA: "tanka"}
"""The names of poems by form."""
MOST_LINES = 20
"""The most lines that feedback names; a poem can have thousands."""


@claim
class Goal(Claim[Truth, Poem]):
    """True if the poem, of this form, must have this pattern: so many lines with so many syllables each."""

    form: str
    pattern: tuple[int, ...]
    lines = slot(len, "pattern")
    listing = slot(listing_of, "pattern")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer a poem of this pattern, and others with a syllable or a line too many, or a line too few."""
        right = [filler(number) for number in self.pattern]
        wrong = [[filler(n + (i == j)) for j, n in enumerate(self.pattern)] for i in range(len(self.pattern))]
        return (
            self.form == TITLES.get(lab.form, "poem")
            and solves(lab, moment.after, right)
            and not any(solves(lab, moment.after, lines) for lines in (*wrong, [*right, right[-1]], right[:-1]))
        )


@claim
class FreeGoal(Claim[Truth, Poem]):
    """True if every line must have `syllables` syllables, in a poem of any number of lines from one up."""

    syllables: int

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer poems of several lengths, and others with a syllable too many or without a line."""
        right, wrong = filler(self.syllables), filler(self.syllables + 1)
        return all(solves(lab, moment.after, [right] * lines) for lines in (1, 2, 3, 30)) and not any(
            solves(lab, moment.after, lines) for lines in ([], [wrong], [right, wrong])
        )


@claim
class Counting(Claim[Truth, Poem]):
    """True if a word may be read with any pronunciation of CMUdict, and is estimated where it is not listed."""

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer `fire`, which is listed with one and with two syllables, and a word that is not listed."""
        return plays(lab, "fire", 1) and plays(lab, "fire", 2) and plays(lab, "glimmerfoam", 3)


@claim
class Answer(Claim[Truth, Poem]):
    """True if lines of verse are lines of text, blank lines do not count, and so many characters are allowed."""

    limit: int

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer two lines with and without a blank one between them, and as one; and texts about the limit."""
        two = Truth((1, 1), False, "")
        return (
            solves(lab, two, ["la", "la"])
            and solves(lab, two, ["la", " ", "la"])
            and not solves(lab, two, ["la la"])
            and lab.action_space.contains("x" * self.limit)
            and not lab.action_space.contains("x" * (self.limit + 1))
        )


@claim
class _Tried(Verdict[Truth, Poem]):
    tried = True
    words: str
    line: Line
    counted: int
    required: int

    def applies(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer the line as a poem of its own that must have `counted` syllables."""
        return required_of(moment.after, self.line) == self.required and plays(lab, self.words, self.counted)

    def good(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer it as a poem that must have `required` syllables."""
        return plays(lab, self.words, self.required)


@claim
class TriedWell(_Tried):
    """True if `words` can be read with `counted` syllables, and with `required`, which line `line` must have."""

    kind = HP

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """The opposite verdict, by counting wrong."""
        return tuple(self.opposing(counted=counted) for counted in near(self.required))


@claim
class TriedInVain(_Tried):
    """True if `words` can be read with `counted` syllables but not with `required`, which line `line` must have."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Solution(ActionClaim[Truth, Poem]):
    """True if the poem `action` is right."""

    action: str

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer it."""
        return solves(lab, moment.after, [self.action])


@claim
class AllRight(Claim[Truth, Poem]):
    """True if every line of the last poem can be read with the required number of syllables, and none is missing."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer the poem again."""
        return moment.before is not None and solves(lab, moment.before, [moment.action])

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Find fault with the first line."""
        return _faults(moment, 1)


@claim
class LinesRight(Claim[Truth, Poem]):
    """True if these lines of the last poem, which has the right number of lines, can be read with their syllables."""

    kind = HP
    lines: tuple[Line, ...]
    listing = slot(numbered_lines, "lines")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer each line as a poem of its own."""
        return all(
            judged(moment, line) and plays(lab, line_of(moment, line), required_of(moment.past, line))
            for line in self.lines
        )

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Praise the other lines, or find fault with these."""
        others = tuple(i for i in range(1, len(lines_of(moment.action)) + 1) if i not in self.lines)[:MOST_LINES]
        praise = (LinesRight(lines=others),) if others else ()
        return (*praise, *_faults(moment, self.lines[0]))


@claim
class WrongLine(Claim[Truth, Poem]):
    """True if a line of the last poem can be read with `counted` syllables but not with `required`, as it must be."""

    kind = HN
    line: Line
    counted: int
    required: int
    reading = slot(syllables_of, "counted")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer the line as a poem of its own."""
        if not judged(moment, self.line) or self.required != required_of(moment.past, self.line):
            return False
        words = line_of(moment, self.line)
        return plays(lab, words, self.counted) and not plays(lab, words, self.required)

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Count wrong, or praise the line."""
        counts = (n for n in near(self.counted) if n != self.required)
        wrong = (WrongLine(line=self.line, counted=n, required=self.required) for n in counts)
        return (*wrong, LinesRight(lines=(self.line,)))


@claim
class WrongNumber(Claim[Truth, Poem]):
    """True if the last poem has `lines` lines, at least one, and must have `required`."""

    kind = HN
    lines: int
    required: int
    length = slot(length_of, "lines")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Count the lines that hold more than space, and ask for so many."""
        return (
            moment.before is not None
            and self.lines == sum(not line.isspace() for line in moment.action.splitlines() if line) > 0
            and not moment.before.free
            and self.required == len(moment.before.pattern) != self.lines
        )

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Count the lines wrong."""
        counts = (n for n in near(self.lines) if n and n != self.required)
        return (*(WrongNumber(lines=n, required=self.required) for n in counts), AllRight())


@claim
class Empty(Claim[Truth, Poem]):
    """True if the last poem has no line."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Look for a character that is not whitespace."""
        return moment.before is not None and (not moment.action or moment.action.isspace())

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Claim that it has lines."""
        required = len(moment.past.pattern)
        return WrongNumber(lines=required + 1, required=required), AllRight()


@claim
class Write(ActionClaim[Truth, Poem], EditClaim[Truth, Poem]):
    """True if the poem `action` earns more than the last one, and has as line `line` these words, which fit there."""

    kind = FP
    action_slot = ""
    action: str
    line: Line
    syllables: int
    amount = slot(syllables_of, "syllables")

    @property
    def words(self) -> str:  # type: ignore[override]  # they follow from the poem
        """The line."""
        return "".join(self.action.split("\n")[self.line - 1 : self.line])

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer both poems, and the line as a poem of its own."""
        return (
            self.line >= 1
            and required_of(moment.after, self.line) == self.syllables
            and plays(lab, self.words, self.syllables)
            and pays(lab, moment.after, self.action) > pays(lab, moment.after, moment.after.draft)
        )

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Miscount the syllables of the line."""
        return _miscounted(self.action.split("\n"), self.line, self.syllables)

    def coarser(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """The line to work on, then its number of syllables."""
        return Work.on(self, line=self.line), Count(line=self.line, syllables=self.syllables)


@claim
class Work(Grounded[Truth, Poem]):
    """True if another line `line` can make a poem that earns more than the last one."""

    kind = FP
    line: Line

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer the poem of the ground."""
        return self.line == self._ground.line and self.stands(moment, lab)

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Offer the last poem with a line of the required length in its place."""
        truth, lab = moment.after, oracle.lab
        lines, syllables = lines_of(truth.draft), required_of(truth, self.line)
        if not syllables or self.line < 1:
            return False
        count = max(len(lines), self.line) if truth.free else len(truth.pattern)
        lines = editable((*lines, *(PLACEHOLDER,) * (count - len(lines)))[:count], truth)
        better = advise_line(lines, self.line, syllables, syllables).action
        return pays(lab, truth, better) > pays(lab, truth, truth.draft)


@claim
class Count(Claim[Truth, Poem]):
    """True if line `line` must have so many syllables."""

    kind = FP
    scope = Scope.WORLD
    line: Line
    syllables: int
    amount = slot(syllables_of, "syllables")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer a line with so many syllables where a line like that is asked for."""
        return plays(lab, filler(self.syllables), required_of(moment.after, self.line))

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Another number."""
        return tuple(Count(line=self.line, syllables=number) for number in near(self.syllables) if number)


@claim
class Shorten(ActionClaim[Truth, Poem], EditClaim[Truth, Poem]):
    """True if `action`, which is the last poem up to line `line`, is right and the last poem is not."""

    kind = FP
    action_slot = ""
    cuts = True
    action: str

    @property
    def line(self) -> int:  # type: ignore[override]  # it follows from the poem
        """The last line that stays."""
        return self.action.count("\n") + 1

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer both poems."""
        draft = moment.after.draft
        kept = tuple(self.action.split("\n")) == lines_of(draft)[: self.line]
        right, was_right = (solves(lab, moment.after, [poem]) for poem in (self.action, draft))
        return kept and right and not was_right

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Cut it a line too early or too late."""
        lines = lines_of(moment.after.draft)
        return tuple(Shorten(action="\n".join(lines[:n])) for n in near(self.line) if 1 <= n <= len(lines))


@claim
class Repeat(Solution):
    """True if `action` is the last poem, and is right."""

    kind = FP
    action_slot = ""

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer it again."""
        return self.action == moment.after.draft and Solution.holds(self, moment, lab)

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Put a line in it that does not fit."""
        lines = editable(lines_of(self.action), moment.after)
        return _miscounted(lines, 1, required_of(moment.after, 1))


@claim
class AvoidCount(Claim[Truth, Poem]):
    """True if line `line` must not be one of `counted` syllables: it must have another number of them."""

    kind = FN
    scope = Scope.WORLD
    line: Line
    counted: int
    amount = slot(syllables_of, "counted")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer a line with the required number where a line of so many syllables is asked for."""
        return not plays(lab, filler(required_of(moment.after, self.line)), self.counted)

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Warn of the required number."""
        return (AvoidCount(line=self.line, counted=required_of(moment.after, self.line)),)


@claim
class AvoidLines(Claim[Truth, Poem]):
    """True if the poem must not have `lines` lines, at least one."""

    kind = FN
    scope = Scope.WORLD
    lines: int
    length = slot(length_of, "lines")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer so many lines of one syllable where each line must have one: they must not earn anything."""
        truth = moment.after
        ones = Truth((1,) * len(truth.pattern), truth.free, "")
        return self.lines >= 1 and pays(lab, ones, "\n".join("a" * self.lines)) == -1.0

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Warn of the required number."""
        return (AvoidLines(lines=len(moment.after.pattern)),)


@claim
class LinesLeft(Claim[Truth, Poem]):
    """True if just so many lines of the last poem, which has the right number of lines, must have other syllables."""

    kind = FP
    lines: Annotated[int, Range(0, 99)]
    length = slot(length_of, "lines")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer each line as a poem of its own."""
        truth = moment.after
        lines = lines_of(truth.draft)
        wrong = sum(not plays(lab, words, required_of(truth, i)) for i, words in enumerate(lines, 1))
        return bool(truth.demands(len(lines))) and wrong == self.lines

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Another number."""
        return tuple(LinesLeft(lines=number) for number in near(self.lines) if number)


@claim
class Total(Claim[Truth, Poem]):
    """True if a right poem, whose number of lines is given, has so many syllables."""

    kind = FP
    scope = Scope.WORLD
    syllables: int
    amount = slot(syllables_of, "syllables")

    def holds(self, moment: Moment[Truth], lab: Poem) -> bool:
        """Offer lines of growing length."""
        return not moment.after.free and sum(_needs(moment.after, lab)) == self.syllables

    def counterparts(self, moment: Moment[Truth], lab: Poem) -> Sequence[Claim]:
        """Another number."""
        return tuple(Total(syllables=number) for number in near(self.syllables) if number)


def _needs(truth: Truth, lab: Poem) -> list[int]:
    """Per line, the number of syllables that makes it right."""
    each = (required_of(truth, line) for line in range(1, len(truth.pattern) + 1))
    return [next(n for n in range(1, required + 2) if plays(lab, filler(n), required)) for required in each]


def _faults(moment: Moment[Truth], line: int) -> tuple[Claim, ...]:
    required = required_of(moment.past, line)
    return tuple(WrongLine(line=line, counted=counted, required=required) for counted in near(required))


def _miscounted(lines: Sequence[str], line: int, syllables: int) -> tuple[Write, ...]:
    return tuple(advise_line(lines, line, syllables, wrong) for wrong in near(syllables) if wrong)


def advise_line(lines: Sequence[str], line: int, syllables: int, number: int) -> Write:
    """Advice to put a line of `number` syllables in a place that requires `syllables`."""
    action = "\n".join((*lines[: line - 1], compose(number, line), *lines[line:]))
    return Write(action=action, line=line, syllables=syllables)
