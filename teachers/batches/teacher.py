"""Teachers in arrays: what the oracle states in each row, and what a personality leaves of it."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from teachers.atoms import KINDS, Claim, Moment
from teachers.batches import Kinds, Memory, Moments, OracleBatch, Said, StageBatch
from teachers.common import Late
from teachers.personality import PERSONALITIES, Personality, parse_personality, stages_of
from teachers.spec import fits
from teachers.teacher import Teacher
from worlds.batches import Rows, merged


class _Mute(StageBatch[Personality]):
    """Withholds everything."""

    def speak(self, kinds: Kinds, memory: Memory, moments: Moments[Any]) -> tuple[Kinds, Memory]:
        return np.zeros_like(kinds), memory


class TeacherBatch:
    """The teacher of each row: `teachers.teacher.Teacher` in arrays, but for its words.

    Args:
        oracle: the oracles of the rows.
        personality: a spec string or a `Personality`, each of whose stages withholds or delays kinds of claims.
        wanted: the kinds that may be said at all, as a subset's number.
        rows: number of rows.
        max_turns: turns after which an episode is truncated.
        instead: what takes other personalities, for the error.

    Raises:
        ValueError: the personality is not allowed in arrays.
    """

    def __init__(
        self, oracle: OracleBatch[Any], personality: Any, wanted: np.uint8, rows: int, max_turns: int, instead: str
    ) -> None:
        if not isinstance(personality, str | Personality):
            raise ValueError(
                f"in arrays teacher must be a spec string or a Personality, got {personality!r}; others: {instead}"
            )
        self.oracle, self.personality = oracle, parse_personality(personality)
        self._wanted = wanted
        self._stages: list[StageBatch[Any]] = []
        for stage in stages_of(self.personality):
            batch = _batch_of(type(stage))
            if batch is None:
                able = ", ".join(name for name in PERSONALITIES.names if _batch_of(PERSONALITIES[name]))
                raise ValueError(f"the personality {stage} cannot play in arrays; allowed: {able}; others: {instead}")
            if not stage.transparent:
                self._stages.append(batch(stage, oracle, max_turns))
        self.late = sum(stage.late for stage in self._stages)
        """Turns by which everything that is said is late."""
        self._memory = [stage.blank(rows) for stage in self._stages]
        self._before = [*self._memory]  # when they spoke last
        self._kinds: Kinds = np.zeros(rows, np.uint8)

    def judge(self, moments: Moments[Any], rows: Rows, past: Sequence[Moments[Any]]) -> tuple[Said, Moments[Any]]:
        """What is said, and the moments that it is about. Each moment of a row must be judged once as a new one.

        Args:
            moments: the last ones.
            rows: the rows in which they are new.
            past: those before, the latest first; at least `late` of them if so many turns have been played.
        """
        said = self.oracle.judge(moments)
        if not self._stages:
            return said._replace(kinds=said.kinds & self._wanted), moments
        kinds: Kinds = (said.kinds & self._wanted)[rows]
        taken = self.oracle.worlds.taken
        new: Moments[Any] = Moments(*(taken(each, rows) if isinstance(each, tuple) else each[rows] for each in moments))
        opening = np.flatnonzero(new.turn == 0)
        for number, stage in enumerate(self._stages):
            before = type(memory := self._memory[number])(*(array[rows] for array in memory))
            before = merged(before, opening, stage.blank(len(opening)))
            kinds, after = stage.speak(kinds, before, new)
            self._before[number], self._memory[number] = (
                merged(old, rows, now) for old, now in ((self._before[number], before), (memory, after))
            )
        self._kinds = self._kinds.copy()
        self._kinds[rows] = kinds
        if self.late and len(past) >= self.late:
            moments = past[self.late - 1]
            said = self.oracle.judge(moments)
        return said._replace(kinds=self._kinds), moments

    def remind(self, teacher: Teacher, row: int, turn: int, moment: Callable[[int], Moment[Any]]) -> None:
        """Copy what a row remembered before it spoke last into a teacher.

        Args:
            teacher: a teacher with the same personality that has begun the episode.
            row: number of the row.
            turn: number of turns so far.
            moment: gives the row's moment of so many turns ago.
        """
        late = 0

        def recall(ago: int, kinds: int) -> tuple[Claim[Any], ...]:
            about = moment(ago + late)
            wanted = {kind for bit, kind in enumerate(KINDS) if kinds >> bit & 1}
            return tuple(Late(claim=each, turn=about.turn) for each in teacher.oracle.judge(about, wanted))

        stages = [stage for stage in teacher.stages if not stage.spec.transparent]
        for stage, batch, before in zip(stages, self._stages, self._before, strict=True):
            batch.remind(stage, before, row, turn, recall)
            late += batch.late


def _batch_of(cls: type[Personality]) -> type[StageBatch[Any]] | None:
    """The form of a personality in arrays; None if it has none."""
    if cls.batch is not None and fits(cls, "batch", "stage"):
        return cls.batch
    return _Mute if cls.transparent is True or cls.mute is True else None
