"""TAMER in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from llf_teacher.students.batches import Seats
from llf_teacher.students.batches.evaluated import EvaluatedBatch
from llf_teacher.students.evaluated import Evaluated
from llf_teacher.students.student import Policy
from worlds.batches import Floats, Ints


class Tamers(EvaluatedBatch):
    """A table of expected labels per row."""

    def __init__(self, spec: Evaluated, seats: Seats) -> None:
        super().__init__(spec, seats)
        self.table = np.zeros((seats.rows, seats.states, seats.actions))
        """Expected label per row, state and action."""

    def clear(self, rows: Ints) -> None:
        """Forget all labels."""
        self.table[rows] = 0

    def hear(self, rows: Ints, steps: Ints, labels: Floats, late: bool = False) -> None:
        """A step towards the labels; silence is not a label."""
        alpha = np.where(labels, self.parameter("alpha", rows), 0.0)
        at, values = rows * self.states * self.actions + steps, self.table.reshape(-1)
        values[at] += alpha * (labels - values[at])

    def choose(self, rows: Ints, places: Ints) -> Ints:
        """Actions of the greatest predictions."""
        return self.best(rows, self.table[rows, places])

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row, including its table."""
        super().teach(policy, row, turn, seen, here)
        policy.recall(dict(zip(seen, self.table[row], strict=True)))  # type: ignore[attr-defined]  # the tamer policy's
