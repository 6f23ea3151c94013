"""Students in arrays that learn from praise and blame."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from llf_teacher.students.batches import Seats, StudentBatch
from llf_teacher.students.evaluated import Evaluated, EvaluatedPolicy
from llf_teacher.students.scene import HeardBatch
from llf_teacher.students.student import Policy
from teachers.atoms import HN, HP
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, most


class EvaluatedBatch(StudentBatch[Evaluated]):
    """`EvaluatedPolicy` in arrays; arguments as of the base."""

    def __init__(self, spec: Evaluated, seats: Seats) -> None:
        super().__init__(spec, seats)
        self._count = np.zeros(seats.rows, np.int64)  # steps of the episode
        self._depth = seats.late + 1
        self._steps = np.zeros((seats.rows, self._depth), np.int64)  # state * actions + action of the last ones

    def start(self, rows: Ints) -> None:
        """Begin an episode with what is remembered."""
        self._count[rows] = 0

    def act(self, rows: Ints, places: Ints, rewards: Floats, heard: HeardBatch) -> Ints:
        """Learn from the evaluation of earlier actions, then choose the next."""
        self._evaluate(rows, heard.kinds)
        actions = self.choose(rows, places)
        self._count[rows] += 1
        self.take(rows, places, actions)
        return actions

    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the actions of a turn."""
        self._steps[rows, (self._count[rows] - 1) % self._depth] = places * self.actions + actions

    def finish(self, rows: Ints, places: Ints, rewards: Floats, terminated: Bools, heard: HeardBatch) -> None:
        """Learn from the evaluation of the last actions."""
        self._evaluate(rows, heard.kinds)
        self._count[rows] = 0

    def _evaluate(self, rows: Ints, kinds: Ints) -> None:
        """Learn from late verdicts, then from the verdict on the last turn, or its absence."""
        labels = (kinds & BIT[HP] > 0).astype(float) - (kinds & BIT[HN] > 0)
        if self.late:
            due = np.flatnonzero((labels != 0) & (self._count[rows] > self.late))
            self.hear(rows[due], self._step(rows[due], self.late), labels[due], late=True)
            labels = np.zeros(len(rows))
        acted = np.flatnonzero(self._count[rows] > 0)
        self.hear(rows[acted], self._step(rows[acted], 0), labels[acted])

    def _step(self, rows: Ints, ago: int) -> Ints:
        step: Ints = self._steps[rows, (self._count[rows] - 1 - ago) % self._depth]
        return step

    def best(self, rows: Ints, scores: Floats) -> Ints:
        """Actions of the greatest scores, shape (n, actions); ties are broken at random."""
        ties = scores >= most(scores)[:, None] - 1e-12
        actions: Ints = ties.argmax(axis=1)
        several = np.flatnonzero(np.count_nonzero(ties, axis=1) > 1)
        actions[several] = self.drawn_from(ties[several], rows[several])
        return actions

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row; of the steps those that may still be evaluated."""
        assert isinstance(policy, EvaluatedPolicy)  # noqa: S101  # that of its student
        policy.rng = self.streams.stream(row)
        count, steps = int(self._count[row]), []
        for ago in reversed(range(count)):
            place, action = divmod(int(self._step(np.array([row]), ago)[0]), self.actions)
            steps.append(((seen[place],), action))
        policy.resume_at(steps)

    @abstractmethod
    def choose(self, rows: Ints, places: Ints) -> Ints:
        """`EvaluatedPolicy.choose`."""

    @abstractmethod
    def hear(self, rows: Ints, steps: Ints, labels: npt.NDArray[np.float64], late: bool = False) -> None:
        """Learn from labels of steps: 1 praise, -1 blame, 0 silence; `late`: silence was heard of them before."""
