"""delayed(turns): claims arrive some turns late (TAMER's credit assignment problem)."""

from collections import deque
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from teachers.batches import Kinds, Moments, OracleBatch
from teachers.common import Late
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range
from worlds.batches import Floats


class _Delay(Stage["Delayed"]):
    """Keeps the claims that are still to be said."""

    def begin(self) -> None:
        self._queue: deque[Claims] = deque()

    def speak(self, claims: Claims, view: View) -> Claims:
        late = [c if isinstance(c, Late) else Late(claim=c, turn=view.turn) for c in claims]
        self._queue.append(tuple(late) if self.spec.turns else claims)
        return self._queue.popleft() if len(self._queue) > self.spec.turns else ()


@dataclass(frozen=True)
class Delayed(Personality):
    """Says each claim some turns late; claims still waiting at the end of the episode are lost."""

    turns: Annotated[int, Range(0, 10_000)] = 1
    """The delay in turns, at least 0."""

    source = "TAMER: Knox & Stone 2009"
    stage = _Delay

    @property
    def row_delay(self) -> int:
        """The delay."""
        return self.turns

    def speak_rows(self, kinds: Kinds, memory: Floats, moments: Moments[Any], oracle: OracleBatch[Any]) -> Kinds:
        """`_Delay.speak` in arrays. The memory holds the waiting kinds, the oldest first."""
        queue = np.column_stack((memory, kinds))
        memory[:] = queue[:, 1:]
        return queue[:, 0].astype(np.uint8)
