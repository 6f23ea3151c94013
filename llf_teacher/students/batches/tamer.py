"""TAMER in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from llf_teacher.students.batches import Seats, StudentBatch
from llf_teacher.students.builtin.tamer import Tamer
from llf_teacher.students.scene import HeardBatch
from llf_teacher.students.student import Policy
from teachers.atoms import HN, HP
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, most


class Tamers(StudentBatch[Tamer]):
    """A table of expected labels per row; arguments as in the base class."""

    def __init__(self, spec: Tamer, seats: Seats) -> None:
        super().__init__(spec, seats)
        self.table = np.zeros((seats.rows, seats.states, seats.actions))
        """Expected label per row, state and action."""
        self._count = np.zeros(seats.rows, np.int64)  # steps of the episode
        self._depth = seats.late + 1
        self._steps = np.zeros((seats.rows, self._depth), np.int64)  # state * actions + action of the last steps

    def clear(self, rows: Ints) -> None:
        """Forget all labels."""
        self.table[rows] = 0

    def start(self, rows: Ints) -> None:
        """Begin an episode with what is remembered."""
        self._count[rows] = 0

    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> Ints:
        """Learn from the labels, then take the actions of the greatest predictions; ties are broken at random."""
        self._learn(rows, heard.kinds)
        predictions = self.table[rows, places]
        ties = predictions >= most(predictions)[:, None] - 1e-12
        actions: Ints = ties.argmax(axis=1)
        several = np.flatnonzero(np.count_nonzero(ties, axis=1) > 1)
        actions[several] = self.drawn_from(ties[several], rows[several])
        self._count[rows] += 1
        self.take(rows, places, actions)
        return actions

    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the actions of a turn."""
        self._steps[rows, (self._count[rows] - 1) % self._depth] = places * self.actions + actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Learn from the labels of the last actions."""
        self._learn(rows, heard.kinds)
        self._count[rows] = 0

    def _learn(self, rows: Ints, kinds: Ints) -> None:
        """A step towards the labels: 1 praise, -1 blame; silence is not a label."""
        labels = (kinds & BIT[HP] > 0).astype(float) - (kinds & BIT[HN] > 0)
        labelled = np.flatnonzero((labels != 0) & (self._count[rows] > self.late))
        rows, labels = rows[labelled], labels[labelled]
        at, values = rows * self.states * self.actions + self._step(rows, self.late), self.table.reshape(-1)
        values[at] += self.parameter("alpha", rows) * (labels - values[at])

    def _step(self, rows: Ints, ago: int) -> Ints:
        step: Ints = self._steps[rows, (self._count[rows] - 1 - ago) % self._depth]
        return step

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the table of a row, and the steps that may still be evaluated."""
        policy.rng = self.streams.stream(row)
        count, steps = int(self._count[row]), []
        for ago in reversed(range(count)):
            place, action = divmod(int(self._step(np.array([row]), ago)[0]), self.actions)
            steps.append(((seen[place],), action))
        policy.resume_at(steps)  # type: ignore[attr-defined]  # a method of the tamer policy
        policy.recall(dict(zip(seen, self.table[row], strict=True)))  # type: ignore[attr-defined]  # likewise
