"""SABL and I-SABL in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from llf_teacher.students.batches import Seats
from llf_teacher.students.batches.evaluated import EvaluatedBatch
from llf_teacher.students.builtin.sabl import GRID, Sabl, log_chances
from llf_teacher.students.evaluated import Evaluated
from llf_teacher.students.student import Policy
from worlds.batches import Floats, Ints


class Sabls(EvaluatedBatch):
    """Log-likelihoods per row, state, action that may be best, and strategy of the trainer.

    With `infers` there are 100 strategies: 800 bytes for each row, state and action.
    """

    spec: Sabl

    def __init__(self, spec: Evaluated, seats: Seats) -> None:
        super().__init__(spec, seats)
        strategies = len(GRID[0]) if self.spec.infers else 1
        self.table = np.zeros((seats.rows * seats.states, seats.actions, strategies))
        """Log-likelihoods of what was heard in a state, shape (rows * states, actions, strategies)."""
        self._heard = np.zeros(seats.rows * seats.states, bool)
        self._evidence = np.zeros((seats.rows, strategies))  # log-likelihood of all labels, but for a constant
        self._log = np.zeros((2, 3, seats.rows, strategies))

    def clear(self, rows: Ints) -> None:
        """Forget all labels."""
        every = (rows[:, None] * self.states + np.arange(self.states)).ravel()
        self.table[every], self._heard[every], self._evidence[rows] = 0, False, 0
        values = (np.broadcast_to(self.parameter(name, rows), rows.shape) for name in ("error", "plus", "minus"))
        error, plus, minus = (each[:, None] for each in values)
        self._log[:, :, rows] = log_chances(error, *(GRID if self.spec.infers else (plus, minus)))

    def hear(self, rows: Ints, steps: Ints, labels: Floats, late: bool = False) -> None:
        """Update the likelihoods; a label that comes late takes the place of the silence."""
        if late:
            self._multiply(rows, steps, np.zeros(len(rows)), -1)
        self._multiply(rows, steps, labels, 1)

    def _multiply(self, rows: Ints, steps: Ints, labels: Floats, times: int) -> None:
        """Multiply likelihoods by those of labels, or divide them with `times=-1`."""
        place, action = np.divmod(steps, self.actions)
        at, event = rows * self.states + place, labels.astype(np.int64) + 1
        wrong, right = self._log[0, event, rows], self._log[1, event, rows]
        self._heard[at] = True
        self._evidence[rows] -= np.logaddexp.reduce(self.table[at], axis=1)
        self.table[at] += times * wrong[:, None]
        self.table[at, action] += times * (right - wrong)
        self._evidence[rows] += np.logaddexp.reduce(self.table[at], axis=1)

    def choose(self, rows: Ints, places: Ints) -> Ints:
        """The actions that are most probably the best."""
        at, evidence = rows * self.states + places, self._evidence[rows]
        weights = np.exp(evidence - evidence.max(axis=1, keepdims=True))
        weights /= weights.sum(axis=1, keepdims=True)
        table = self.table[at]
        chances = np.exp(table - np.logaddexp.reduce(table, axis=1)[:, None])
        chances[~self._heard[at]] = 1.0  # so that all are drawn alike
        return self.best(rows, (chances * weights[:, None]).sum(axis=2))

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row, including its likelihoods."""
        super().teach(policy, row, turn, seen, here)
        at = range(row * self.states, (row + 1) * self.states)
        heard = {state: self.table[i].copy() for state, i in zip(seen, at, strict=True) if self._heard[i]}
        count = int(self._count[row])
        silent = set(range(max(count - self.late, 1), count))
        policy.recall(heard, silent)  # type: ignore[attr-defined]  # a method of the sabl policy
