"""Teachers in arrays: an oracle and a personality for many rows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from teachers.batches import Kinds, Moments, OracleBatch, Said
from teachers.personality import PERSONALITIES, Personality, parse_personality, stages_of
from worlds.batches import Rows


class TeacherBatch:
    """The teacher of each row: `teachers.teacher.Teacher` in arrays, without words.

    Args:
        oracle: the oracles of the rows.
        personality: a spec string or a `Personality`, whose stages have a form in arrays.
        wanted: the kinds that the feedback type allows, as a subset's number.
        rows: number of rows.
        max_turns: turns after which an episode is truncated.
        instead: what serves other personalities, for the error message.

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
        self.oracle, self.personality, self._wanted = oracle, parse_personality(personality), wanted
        stages = stages_of(self.personality)
        for stage in stages:
            if not stage.in_arrays():
                able = ", ".join(name for name in PERSONALITIES.names if PERSONALITIES[name].in_arrays())
                raise ValueError(f"the personality {stage} cannot play in arrays; allowed: {able}; others: {instead}")
        never = max_turns + 1
        self._stages = [
            (stage, np.zeros((rows, stage.row_memory + min(stage.row_delay, never))))
            for stage in stages
            if not stage.transparent
        ]
        self.late = sum(min(stage.row_delay, never) for stage in stages)
        """How many turns earlier the turn is that all claims are about."""
        self.past = max_turns if any(table.size for _, table in self._stages) else 0
        """How many earlier moments a scalar teacher needs to continue like this one."""
        self._kinds: Kinds = np.zeros(rows, np.uint8)

    def judge(self, moments: Moments[Any], rows: Rows, past: Sequence[Moments[Any]]) -> tuple[Said, Moments[Any]]:
        """The claims, and the moments that they are about. Each moment of a row must be new in exactly one call.

        Args:
            moments: the last moment of each row.
            rows: the rows whose last moment is new.
            past: the moments before, the latest first.
        """
        said = self.oracle.judge(moments)
        if not self._stages:
            return said._replace(kinds=said.kinds & self._wanted), moments
        kinds, new = said.kinds[rows] & self._wanted, moments.taken(self.oracle.worlds, rows)
        for stage, table in self._stages:
            memory = table[rows]
            memory[new.turn == 0] = 0.0
            kinds = stage.speak_rows(kinds, memory, new, self.oracle)
            table[rows] = memory
        self._kinds[rows] = kinds
        if 0 < self.late <= len(past):
            moments = past[self.late - 1]
            said = self.oracle.judge(moments)
        return said._replace(kinds=self._kinds.copy()), moments
