"""Upper confidence bounds in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from llf_teacher.students.batches import LearnerBatch, Seats
from llf_teacher.students.learner import Learner
from llf_teacher.students.student import Policy
from worlds.batches import Bools, Floats, Ints


class Ucbs(LearnerBatch):
    """Counts and sums per row and action."""

    def __init__(self, spec: Learner, seats: Seats) -> None:
        super().__init__(spec, seats)
        self.count, self.total = np.zeros((seats.rows, seats.actions), np.int64), np.zeros((seats.rows, seats.actions))
        """How often each action's reward was counted, and their sums, shape (rows, actions)."""
        self._rank = np.zeros((seats.rows, seats.actions), np.int64)  # untried actions come in descending order
        self._last = np.zeros(seats.rows, np.int64)

    def clear(self, rows: Ints) -> None:
        """Forget everything; the order of the first actions is random."""
        self.count[rows] = self.total[rows] = 0
        self._rank[rows] = self.streams.permutations(self.actions, rows).argsort(axis=1)

    def learn(self, rows: Ints, places: Ints, rewards: Floats, over: Bools) -> None:
        """Count the rewards."""
        last = self._last[rows]
        self.count[rows, last] += 1
        self.total[rows, last] += rewards

    def choose(self, rows: Ints, places: Ints, wrong: Ints | None = None) -> Ints:
        """The next untried action, else an action of the greatest bound."""
        count = self.count[rows]
        scale = np.broadcast_to(self.parameter("scale", rows), rows.shape)[:, None]
        log, tried = 2 * np.log(np.maximum(count.sum(axis=1, keepdims=True), 1)), np.maximum(count, 1)
        order = np.where(count > 0, self.total[rows] / tried + scale * np.sqrt(log / tried), np.inf)
        fresh = np.where(count > 0, -1, self._rank[rows])
        if wrong is not None:
            every = np.arange(len(rows))
            order[every, wrong], fresh[every, wrong] = -np.inf, -1
        action: Ints = np.where(fresh.max(axis=1) >= 0, fresh.argmax(axis=1), order.argmax(axis=1))
        return action

    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the actions."""
        self._last[rows] = actions

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row, including counts and sums."""
        super().teach(policy, row, turn, seen, here)
        untried = [arm for arm in self._rank[row].argsort().tolist() if not self.count[row, arm]]
        memory = self.count[row].tolist(), self.total[row].tolist(), untried, int(self._last[row])
        policy.recall(*memory)  # type: ignore[attr-defined]  # a method of the ucb policy
