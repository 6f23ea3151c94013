"""The poem's oracle: it counts syllables in every reading, and offers lines that fit."""

from collections.abc import Sequence, Set
from functools import lru_cache

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Grounded, Moment, claim
from teachers.oracle import Oracle
from worlds.poem import HAIKU, MAX_LENGTH, TANKA, Truth, compose, fits, lines_of, readings
from worlds.world import World

PLACEHOLDER = "..."
"""Stands for a line that is still to be written: a line without syllables, so a wrong one."""


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
            self.form == _TITLES.get(lab.form, "poem")
            and self.lines == len(self.pattern)
            and self.listing == _listing(self.pattern)
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
        others = tuple(i for i in range(1, len(lines_of(moment.action)) + 1) if i not in self.lines)[:_TOLD]
        praise = (_lines_right(others),) if others else ()
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
        return (*wrong, _lines_right((self.line,)))


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
        return tuple(_write(lines, self.line, self.syllables, wrong) for wrong in _near(self.syllables) if wrong)

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
        lines = _pliable(lines_of(self.action), moment.after)
        return tuple(_write(lines, 1, required, wrong) for wrong in _near(required) if wrong)


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


def _listing(items: Sequence[int]) -> str:
    return ", ".join(map(str, items[:-1])) + " and " * (len(items) > 1) + str(items[-1])


def _lines_listing(lines: tuple[int, ...]) -> str:
    return ("lines " if len(lines) > 1 else "line ") + _listing(lines)


@lru_cache(maxsize=1024)
def _lines_right(lines: tuple[int, ...]) -> LinesRight:
    return LinesRight(lines=lines, listing=_lines_listing(lines))


@lru_cache(maxsize=1024)
def _nearest(line: str, number: int) -> int:
    """The number of syllables, of those that a line can be read with, that is nearest to `number`."""
    counts = readings(line)
    return min((n for n in range(counts.bit_length()) if counts >> n & 1), key=lambda n: abs(n - number))


def _near(number: int) -> tuple[int, ...]:
    return tuple(n for n in (number - 1, number + 1, number - 2, number + 2) if n >= 0)


def _faults(moment: Moment, line: int) -> tuple[Claim, ...]:
    required = _required(moment.before, line)
    return tuple(WrongLine(line=line, counted=counted, required=required) for counted in _near(required))


def _write(lines: Sequence[str], line: int, syllables: int, number: int) -> Write:
    """Advice to put a line of `number` syllables at a place where `syllables` are required."""
    words = compose(number, line)
    action = "\n".join((*lines[: line - 1], words, *lines[line:]))
    return Write(action=action, line=line, words=words, syllables=syllables)


def _example(truth: Truth) -> tuple[str, ...]:
    """The lines of a poem that is right."""
    pattern = truth.pattern * _FREE_LINES if truth.free else truth.pattern
    return tuple(compose(number, line) for line, number in enumerate(pattern, 1))


def _pliable(lines: tuple[str, ...], truth: Truth) -> tuple[str, ...]:
    """The lines of the last poem, if there is room to edit it; else those of a poem that is right."""
    return lines if len(truth.draft) <= MAX_LENGTH - _ROOM else _example(truth)


_TITLES = {HAIKU: "haiku", TANKA: "tanka"}
_TRIES = 3
_FREE_LINES = 3
_TOLD = 20  # a poem can have thousands of lines; feedback does not speak of more than these
_ROOM = 500  # characters, more than any line that `compose` makes and the placeholders beside it take
_COUNTING, _ANSWER = Counting(), Answer(limit=MAX_LENGTH)
_ALL_RIGHT, _EMPTY = AllRight(), Empty()


class PoemOracle(Oracle):
    """Judges poems line by line, and has the student write them so."""

    max_importance = 1.0

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        pattern = truth.pattern
        if truth.free:
            return FreeGoal(syllables=pattern[0]), _COUNTING, _ANSWER
        form = _TITLES.get(self.lab.options["form"], "poem")
        return Goal(form=form, lines=len(pattern), pattern=pattern, listing=_listing(pattern)), _COUNTING, _ANSWER

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """A few lines that were tried, some of them right; none is told twice."""
        told: dict[Claim, None] = {}
        for _ in range(_TRIES):
            line = int(self.rng.integers(len(truth.pattern))) + 1
            required = truth.pattern[line - 1]
            counted = max(1, required + (0, 0, -1, 1, 2)[self.rng.integers(5)])
            words = compose(counted, int(self.rng.integers(1000)))
            if counted == required:
                told[TriedWell(words=words, line=line, syllables=required)] = None
            else:
                told[TriedInVain(words=words, line=line, counted=counted, required=required)] = None
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        return tuple(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """Lines are judged if their number is right, and at most 20 right and 20 wrong ones are told."""
        lines = lines_of(moment.action)
        wanted = moment.before.demands(len(lines))
        right, wrong = [], []
        for line, (words, required) in enumerate(zip(lines, wanted, strict=False), 1):
            (right if fits(words, required) else wrong).append(line)
        if HP in kinds and right:
            claims.append(_lines_right(tuple(right[:_TOLD])) if wrong else _ALL_RIGHT)
        if HN in kinds:
            for line in wrong[:_TOLD]:
                required = wanted[line - 1]
                claims.append(WrongLine(line=line, counted=_nearest(lines[line - 1], required), required=required))
            if not lines:
                claims.append(_EMPTY)
            elif not wanted:
                claims.append(WrongNumber(lines=len(lines), required=len(moment.before.pattern)))

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """Brought to the right number of lines, the last poem gets a line that fits for its first wrong one."""
        truth = moment.after
        lines = lines_of(truth.draft)
        wanted = truth.demands(len(lines))
        pattern = wanted or truth.pattern
        kept = lines[: len(pattern)] + (PLACEHOLDER,) * (len(pattern) - len(lines))
        line = next((i for i, words in enumerate(kept, 1) if not fits(words, pattern[i - 1])), 0)
        if FP in kinds:
            if line:
                pliable = _pliable(kept, truth)
                place = line if line <= len(pliable) else 1
                claims.append(_write(pliable, place, pattern[place - 1], pattern[place - 1]))
            elif wanted:
                claims.append(Repeat(action=truth.draft))
            else:
                claims.append(Shorten(action="\n".join(kept), lines=len(kept)))
        if FN in kinds:
            if lines and not wanted:
                claims.append(AvoidLines(lines=len(lines)))
            elif lines and line:
                claims.append(AvoidCount(line=line, counted=_nearest(lines[line - 1], pattern[line - 1])))
            else:
                line = moment.turn % len(pattern) + 1
                claims.append(AvoidCount(line=line, counted=pattern[line - 1] + 1))

    def importance(self, truth: Truth) -> float:
        """The reward of a poem that is right less that of one that is all wrong: always 1."""
        return 1.0

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """The same poem `n` times."""
        return ("\n".join(_example(truth)),) * n

    def regret(self, moment: Moment) -> float:
        """The reward of a right poem less the action's: 0 to 1; a turn without an action loses 1."""
        return 1.0 if moment.before is None else 0.0 - moment.reward
