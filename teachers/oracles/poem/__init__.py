"""The poem's oracle: it counts syllables in every reading, and offers lines that fit."""

from collections.abc import Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment
from teachers.oracle import Oracle
from teachers.oracles.poem.claims import (
    PLACEHOLDER,
    TITLES,
    TOLD,
    AllRight,
    Answer,
    AvoidCount,
    AvoidLines,
    Counting,
    Empty,
    FreeGoal,
    Goal,
    LinesRight,
    Repeat,
    Shorten,
    Solution,
    TriedInVain,
    TriedWell,
    WrongLine,
    WrongNumber,
    editable,
    example_of,
    write_line,
)
from worlds.poem import MAX_LENGTH, Poem, Truth, compose, fits, lines_of, readings


def _nearest(line: str, number: int) -> int:
    """The number of syllables, of those that a line can be read with, that is nearest to `number`."""
    counts = readings(line)
    if not counts & counts - 1:  # as it mostly is, there is one
        return counts.bit_length() - 1
    return min((n for n in range(counts.bit_length()) if counts >> n & 1), key=lambda n: abs(n - number))


def _first_wrong(lines: tuple[str, ...], pattern: tuple[int, ...]) -> int:
    """The number of the first line that cannot be read as the pattern wants it; 0 if there is none."""
    for i, words in enumerate(lines):
        if not fits(words, pattern[i]):
            return i + 1
    return 0


_TRIES = 3
_COUNTING, _ANSWER = Counting(), Answer(limit=MAX_LENGTH)
_ALL_RIGHT, _EMPTY = AllRight(), Empty()


class PoemOracle(Oracle[Truth, Poem]):
    """Judges poems line by line, and has the student write them so."""

    max_importance = 1.0

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        pattern = truth.pattern
        if truth.free:
            return FreeGoal(syllables=pattern[0]), _COUNTING, _ANSWER
        form = TITLES.get(self.lab.options["form"], "poem")
        return Goal(form=form, pattern=pattern), _COUNTING, _ANSWER

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A few lines that were tried, some of them right; none is told twice."""
        told: dict[Claim, None] = {}
        for _ in range(_TRIES):
            line = int(rng.integers(len(truth.pattern))) + 1
            required = truth.pattern[line - 1]
            counted = max(1, required + (0, 0, -1, 1, 2)[rng.integers(5)])
            words = compose(counted, int(rng.integers(1000)))
            if counted == required:
                told[TriedWell(words=words, line=line, counted=required, required=required)] = None
            else:
                told[TriedInVain(words=words, line=line, counted=counted, required=required)] = None
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        return tuple(Solution(action=action) for action in self.plan(truth, 1))

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Lines are judged if their number is right, and at most 20 right and 20 wrong ones are told."""
        lines = lines_of(moment.action)
        wanted = moment.past.demands(len(lines))
        right: list[int] = []
        wrong: list[int] = []
        for i, required in enumerate(wanted):  # none, or as many as there are lines
            (right if fits(lines[i], required) else wrong).append(i + 1)
        if HP in kinds and right:
            claims.append(LinesRight(lines=tuple(right[:TOLD])) if wrong else _ALL_RIGHT)
        if HN in kinds:
            for line in wrong[:TOLD]:
                required = wanted[line - 1]
                claims.append(WrongLine(line=line, counted=_nearest(lines[line - 1], required), required=required))
            if not lines:
                claims.append(_EMPTY)
            elif not wanted:
                claims.append(WrongNumber(lines=len(lines), required=len(moment.past.pattern)))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Brought to the right number of lines, the last poem gets a line that fits for its first wrong one."""
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
                claims.append(write_line(pliable, place, pattern[place - 1], pattern[place - 1]))
            elif wanted:
                claims.append(Repeat(action=truth.draft))
            else:
                claims.append(Shorten(action="\n".join(kept)))
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
        return ("\n".join(example_of(truth)),) * n

    def regret(self, moment: Moment[Truth]) -> float:
        """The reward of a right poem less the action's: 0 to 1."""
        return self.idle(moment.after) if moment.before is None else 0.0 - moment.reward

    def idle(self, truth: Truth) -> float:
        """1: no part of what is not there is right."""
        return 1.0
