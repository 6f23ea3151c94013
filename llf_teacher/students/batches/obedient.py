"""The student `obedient` in arrays, where actions are points of a box and a point has the same effect each time."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from llf_teacher.students.batches import Seats, StudentBatch
from llf_teacher.students.builtin.obedient import Obedient
from llf_teacher.students.scene import HeardBatch
from llf_teacher.students.student import Policy
from teachers.atoms import FN, FP, HN, HP
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, without

_OWN, _ADVISED = 0, 1
"""The actions that a student believes right in a state: its own, found without advice, and the advised one."""


class ObedientBatch(StudentBatch[Obedient]):
    """The policy of `obedient` in arrays; arguments as in the base class.

    Raises:
        ValueError: the teacher is late.
    """

    discrete = False

    def __init__(self, spec: Obedient, seats: Seats) -> None:
        super().__init__(spec, seats)
        if seats.late:
            raise ValueError(f"in arrays {spec} needs a teacher that is never late; TeacherEnv takes any teacher")
        shape = seats.space.shape or ()
        self._space: Any = seats.space
        self._held = np.full((seats.rows, seats.states, 2, *shape), np.nan)
        self._right = np.zeros((seats.rows, seats.states, 2), bool)
        self._returns = np.zeros((seats.rows, seats.states), bool)
        """Whether a state may recur: all may, except a drawn point without praise."""
        self._place, self._action = np.zeros(seats.rows, np.int64), np.zeros((seats.rows, *shape))
        self._acted, self._drew = np.zeros(seats.rows, bool), np.zeros(seats.rows, bool)

    def renew(self, rows: Ints) -> None:
        """Begin like a new student of its kind."""
        self._returns[rows] = False
        super().renew(rows)

    def clear(self, rows: Ints) -> None:
        """Forget everything."""
        self._right[rows], self._held[rows] = False, np.nan

    def start(self, rows: Ints) -> None:
        """Begin an episode with what is remembered."""
        self._acted[rows] = False

    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> npt.NDArray[Any]:
        """Learn from the claims, then act; the actions are float, of shape (n, ...)."""
        kinds, advised, warned = heard
        self._hear(rows, places, kinds)
        has = kinds & BIT[FP] > 0
        self._held[rows[has], places[has], _ADVISED] = advised[has]
        self._right[rows[has], places[has], _ADVISED] = True
        warns = kinds & BIT[FN] > 0
        self._judge(rows[warns], places[warns], warned[warns], right=False)
        right, held = self._right[rows, places], self._held[rows, places]
        actions = np.where(right[:, _ADVISED, None], held[:, _ADVISED], held[:, _OWN])
        tries = np.flatnonzero(~right.any(1))
        low, high = self._space.low, self._space.high
        draws = [self.streams.random(rows[tries]) for _ in low]
        actions[tries] = low + (high - low) * np.stack(draws, 1)
        self._drew[rows] = ~right[:, _ADVISED]
        self.take(rows, places, actions)
        return actions

    def take(self, rows: Ints, places: Ints, actions: npt.NDArray[Any]) -> None:
        """Note the actions of a turn."""
        self._place[rows], self._action[rows], self._acted[rows] = places, actions, True

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Learn from the last words of an episode."""
        self._hear(rows, places, heard.kinds)
        self._acted[rows] = False

    def lost(self, rows: Ints) -> Bools:
        """Drawn points, unless they will be proposed again."""
        lost: Bools = ~self._returns[rows]
        return lost

    def forget(self, rows: Ints, lost: Bools, states: int) -> None:
        """Forget the actions of lost states."""
        self._held = without(self._held, rows, lost, states, np.nan)
        self._right = without(self._right, rows, lost, states)
        self._returns = without(self._returns, rows, lost, states)

    def _hear(self, rows: Ints, places: Ints, kinds: Ints) -> None:
        """Learn from the verdict, if any, on the last action, which led to these places."""
        for kind, right in ((HP, True), (HN, False)):
            judged = rows[self._acted[rows] & (kinds & BIT[kind] > 0)]
            self._judge(judged, self._place[judged], self._action[judged], right)
        praised = self._right[rows, self._place[rows], _OWN] & (not self.spec.forget)
        self._returns[rows, places] |= praised | ~(self._acted[rows] & self._drew[rows])

    def _judge(self, rows: Ints, places: Ints, actions: npt.NDArray[Any], right: bool) -> None:
        same = (self._held[rows, places] == actions[:, None]).all(2)
        if right:
            new = np.flatnonzero(~same.any(1))
            self._held[rows[new], places[new], _OWN] = actions[new]
            same[new, _OWN] = True
        row, slot = np.nonzero(same)
        self._right[rows[row], places[row], slot] = right

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row."""
        policy.rng = self.streams.stream(row)
        right: dict[Any, dict[Any, Any]] = {}
        for place, slot in np.argwhere(self._right[row]).tolist():
            action = tuple(self._held[row, place, slot].tolist())
            right.setdefault(seen[place], {})[action] = action
        policy.recall(right, turn, seen[self._place[row]])  # type: ignore[attr-defined]  # a method of `AdviceTaker`
