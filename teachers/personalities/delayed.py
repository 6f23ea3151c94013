"""delayed(turns): claims arrive some turns late (TAMER's credit assignment problem)."""

from collections import deque
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np

from teachers.batches import Kinds, Memory, Moments, OracleBatch, Recall, StageBatch
from teachers.common import Late
from teachers.personality import Claims, Personality, Stage, View
from teachers.spec import Range


class _Delay(Stage["Delayed"]):
    """Keeps the claims that are still to be said."""

    def begin(self) -> None:
        self.queue: deque[Claims] = deque()

    def speak(self, claims: Claims, view: View) -> Claims:
        late = [c if isinstance(c, Late) else Late(claim=c, turn=view.turn) for c in claims]
        self.queue.append(tuple(late) if self.spec.turns else claims)
        return self.queue.popleft() if len(self.queue) > self.spec.turns else ()


class _Queue(NamedTuple):
    kinds: Kinds
    """Those that are still to be said, the oldest first, of shape (rows, turns)."""


class _DelayBatch(StageBatch["Delayed"]):
    """`_Delay` in arrays."""

    def __init__(self, spec: "Delayed", oracle: OracleBatch[Any], max_turns: int) -> None:
        super().__init__(spec, oracle, max_turns)
        self.late = min(spec.turns, max_turns + 1)  # later than ever is never

    def blank(self, rows: int) -> _Queue:
        return _Queue(np.zeros((rows, self.late), np.uint8))

    def speak(self, kinds: Kinds, memory: _Queue, moments: Moments[Any]) -> tuple[Kinds, _Queue]:
        queue = np.column_stack((memory.kinds, kinds))
        return queue[:, 0], _Queue(queue[:, 1:])

    def remind(self, stage: Any, memory: Memory, row: int, turn: int, recall: Recall) -> None:
        kinds = memory[0][row].tolist()
        waits = range(min(turn, self.late), 0, -1)
        stage.queue = deque(recall(ago, kinds[-ago]) if kinds[-ago] else () for ago in waits)


@dataclass(frozen=True)
class Delayed(Personality):
    """Says each claim some turns late; what is left at the end of the episode is lost."""

    turns: Annotated[int, Range(0, 10_000)] = 1
    """The delay in turns, at least 0."""

    source = "TAMER: Knox & Stone 2009"
    stage, batch = _Delay, _DelayBatch
