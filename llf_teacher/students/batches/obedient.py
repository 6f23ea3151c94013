"""The student `obedient` in arrays, where actions are points of a box and a point has the same effect each time."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from llf_teacher.students.advice import AdviceTaker
from llf_teacher.students.builtin.obedient import Obedient
from teachers.atoms import FN, FP, HN, HP
from teachers.session import BIT
from worlds.batches import Bools, Floats, Ints
from worlds.batches.streams import Streams

_OWN, _ADVISED = 0, 1
"""What a student holds for right in a state: an action of its own, found when it held none, and the advised one."""


class ObedientBatch:
    """The policy of `obedient` in arrays: each row draws from its own stream, as a policy would.

    Args: see `LearnerBatch`; `space` is the box of the actions, of shape (n,).
    """

    discrete = False

    def __init__(self, spec: Obedient, rows: int, states: int, space: spaces.Box, streams: Streams) -> None:
        self.spec, self.streams, self._space = spec, streams, space
        self._held = np.full((rows, states, 2, *space.shape), np.nan)
        self._right = np.zeros((rows, states, 2), bool)
        self._place, self._action = np.zeros(rows, np.int64), np.zeros((rows, *space.shape))
        self._acted = np.zeros(rows, bool)

    def enrol(self, rows: Ints, drawn: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put new students into rows; nothing of them can be drawn."""
        self._right[rows], self._held[rows], self._acted[rows] = False, np.nan, False

    def student(self, row: int) -> Obedient:
        """The student of a row."""
        return self.spec

    def begin(self, rows: Ints) -> None:
        """Begin an episode."""
        if self.spec.forget:
            self.enrol(rows, {})

    def act(self, rows: Ints, places: Ints, rewards: Floats, kinds: Ints, advised: Floats, warned: Floats) -> Floats:
        """Learn from what is said, then act; arguments as of `LearnerBatch.act`, of actions float (n, ...)."""
        self._hear(rows, kinds)
        told = kinds & BIT[FP] > 0
        self._held[rows[told], places[told], _ADVISED] = advised[told]
        self._right[rows[told], places[told], _ADVISED] = True
        warns = kinds & BIT[FN] > 0
        self._judge(rows[warns], places[warns], warned[warns], right=False)
        right, held = self._right[rows, places], self._held[rows, places]
        actions = np.where(right[:, _ADVISED, None], held[:, _ADVISED], held[:, _OWN])
        tries = np.flatnonzero(~right.any(1))
        low, high = self._space.low, self._space.high
        draws = [self.streams.random(rows[tries]) for _ in low]
        actions[tries] = low + (high - low) * np.stack(draws, 1)
        self._place[rows], self._action[rows], self._acted[rows] = places, actions, True
        return actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, kinds: Ints) -> None:
        """Learn from the last words of an episode; `kinds` as of `act`."""
        self._hear(rows, kinds)
        self._acted[rows] = False

    def _hear(self, rows: Ints, kinds: Ints) -> None:
        """Learn from the verdict on the last action, if there was one."""
        for kind, right in ((HP, True), (HN, False)):
            judged = rows[self._acted[rows] & (kinds & BIT[kind] > 0)]
            self._judge(judged, self._place[judged], self._action[judged], right)

    def _judge(self, rows: Ints, places: Ints, actions: Floats, right: bool) -> None:
        same = (self._held[rows, places] == actions[:, None]).all(2)
        if right:
            new = np.flatnonzero(~same.any(1))
            self._held[rows[new], places[new], _OWN] = actions[new]
            same[new, _OWN] = True
        row, slot = np.nonzero(same)
        self._right[rows[row], places[row], slot] = right

    def teach(self, policy: AdviceTaker[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row into a policy; see `LearnerBatch.teach`."""
        policy.rng = self.streams.stream(row)
        right: dict[Any, dict[Any, Any]] = {}
        for place, slot in np.argwhere(self._right[row]).tolist():
            action = tuple(self._held[row, place, slot].tolist())
            right.setdefault(seen[place], {})[action] = action
        policy.recall(right, turn, seen[self._place[row]])
