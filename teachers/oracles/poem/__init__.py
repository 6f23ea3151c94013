"""The poem's oracle: it counts syllables in every reading, and composes lines that fit."""

from collections.abc import Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, fast_constructor
from teachers.oracle import Oracle
from teachers.oracles.poem.claims import (
    MOST_LINES,
    PLACEHOLDER,
    TITLES,
    AllRight,
    Answer,
    AvoidCount,
    AvoidLines,
    Count,
    Counting,
    Empty,
    FreeGoal,
    Goal,
    LinesLeft,
    LinesRight,
    Repeat,
    Shorten,
    Solution,
    Total,
    TriedInVain,
    TriedWell,
    WrongLine,
    WrongNumber,
    advise_line,
    editable,
    example_of,
)
from worlds.poem import MAX_LENGTH, Poem, Truth, compose, fits, lines_of, readings


def _nearest(line: str, number: int) -> int:
    """The possible number of syllables of a line that is nearest to `number`."""
    counts = readings(line)
    if not counts & counts - 1:  # the usual case: there is one
        return counts.bit_length() - 1
    return min((n for n in range(counts.bit_length()) if counts >> n & 1), key=lambda n: abs(n - number))


def _first_wrong(lines: tuple[str, ...], pattern: tuple[int, ...]) -> int:
    """The number of the first line that cannot be read as the pattern demands; 0 if there is none."""
    for i, words in enumerate(lines):
        if not fits(words, pattern[i]):
            return i + 1
    return 0


_TRIES = 3
_COUNTING, _ANSWER = Counting(), Answer(limit=MAX_LENGTH)
_ALL_RIGHT, _EMPTY = AllRight(), Empty()
_wrong_line, _avoid_count = fast_constructor(WrongLine), fast_constructor(AvoidCount)


class PoemOracle(Oracle[Truth, Poem]):
    """Judges poems line by line, and advises one line at a time."""

    max_importance = 1.0

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        pattern = truth.pattern
        if truth.free:
            return FreeGoal(syllables=pattern[0]), _COUNTING, _ANSWER
        form = TITLES.get(self.lab.options["form"], "poem")
        return Goal(form=form, pattern=pattern), _COUNTING, _ANSWER

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """Verdicts on a few different lines, some of them right."""
        claims: dict[Claim, None] = {}
        for _ in range(_TRIES):
            line = int(rng.integers(len(truth.pattern))) + 1
            required = truth.pattern[line - 1]
            counted = max(1, required + (0, 0, -1, 1, 2)[rng.integers(5)])
            words = compose(counted, int(rng.integers(1000)))
            if counted == required:
                claims[TriedWell(words=words, line=line, counted=required, required=required)] = None
            else:
                claims[TriedInVain(words=words, line=line, counted=counted, required=required)] = None
        return tuple(claims)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        return tuple(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Judge lines if their number is right, and name at most 20 right and 20 wrong ones."""
        lines = lines_of(moment.action)
        wanted = moment.past.demands(len(lines))
        right: list[int] = []
        wrong: list[int] = []
        for i, required in enumerate(wanted):  # none, or as many as there are lines
            (right if fits(lines[i], required) else wrong).append(i + 1)
        if HP in kinds and right:
            claims.append(LinesRight(lines=tuple(right[:MOST_LINES])) if wrong else _ALL_RIGHT)
        if HN in kinds:
            for line in wrong[:MOST_LINES]:
                required = wanted[line - 1]
                claims.append(_wrong_line(line, _nearest(lines[line - 1], required), required))
            if not lines:
                claims.append(_EMPTY)
            elif not wanted:
                claims.append(WrongNumber(lines=len(lines), required=len(moment.past.pattern)))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Advise the last poem, cut or filled to the right number of lines, with its first wrong line replaced."""
        truth = moment.after
        lines = lines_of(truth.draft)
        wanted = truth.demands(len(lines))
        pattern = wanted or truth.pattern
        kept = lines[: len(pattern)] + (PLACEHOLDER,) * (len(pattern) - len(lines))
        line = _first_wrong(kept, pattern)
        if FP in kinds:
            if line:
                pliable = editable(kept, truth)
                place = line if line <= len(pliable) else 1
                claims.append(advise_line(pliable, place, pattern[place - 1], pattern[place - 1]))
            elif wanted:
                claims.append(Repeat(action=truth.draft))
            else:
                claims.append(Shorten(action="\n".join(kept)))
        if FN in kinds:
            if lines and not wanted:
                claims.append(AvoidLines(lines=len(lines)))
            elif lines and line:
                claims.append(_avoid_count(line, _nearest(lines[line - 1], pattern[line - 1])))
            else:
                line = moment.turn % len(pattern) + 1
                claims.append(_avoid_count(line, pattern[line - 1] + 1))

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """The number of wrong lines, the total of syllables, then each line's."""
        lines, pattern = lines_of(truth.draft), truth.pattern
        wanted = truth.demands(len(lines))
        wrong = sum(not fits(words, number) for words, number in zip(lines, wanted, strict=False))
        if wanted and not wrong:
            return ()
        return (
            *((LinesLeft(lines=wrong),) if wanted else ()),
            *(() if truth.free else (Total(syllables=sum(pattern)),)),
            *(Count(line=line, syllables=number) for line, number in enumerate(pattern, 1)),
        )

    def importance(self, truth: Truth) -> float:
        """The reward of a right poem minus that of an entirely wrong one: always 1."""
        return 1.0

    def plan(self, truth: Truth, n: int) -> tuple[str, ...]:
        """The same poem `n` times."""
        return ("\n".join(example_of(truth)),) * n

    def regret(self, moment: Moment[Truth]) -> float:
        """The reward of a right poem minus the action's: 0 to 1."""
        return self.idle(moment.after) if moment.before is None else 0.0 - moment.reward

    def idle(self, truth: Truth) -> float:
        """1: without a poem no line is right."""
        return 1.0
