"""Tabular Q-learning in arrays."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from llf_teacher.students.batches import LearnerBatch, Seats
from llf_teacher.students.learner import Learner
from llf_teacher.students.student import Policy
from worlds.batches import Bools, Floats, Ints, most


class QLearners(LearnerBatch):
    """A table of values per row."""

    def __init__(self, spec: Learner, seats: Seats) -> None:
        super().__init__(spec, seats)
        self.table = np.zeros((seats.rows, seats.states, seats.actions))
        """Value per row, state and action."""
        self._last = np.zeros(seats.rows, np.int64)  # index of the last action's value in the flattened table

    def clear(self, rows: Ints) -> None:
        """Start with empty tables."""
        optimism = np.broadcast_to(self.parameter("optimism", rows), rows.shape)
        self.table[rows] = optimism[:, None, None]

    def learn(self, rows: Ints, places: Ints, rewards: Floats, over: Bools) -> None:
        """One step of the method."""
        alpha, gamma = self.parameter("alpha", rows), self.parameter("gamma", rows)
        last, values = self._last[rows], self.table.reshape(-1)
        value, after = values[last], np.where(over, 0.0, most(self.table[rows, places]))
        values[last] = value + alpha * (rewards + gamma * after - value)

    def choose(self, rows: Ints, places: Ints, wrong: Ints | None = None) -> Ints:
        """An action of the greatest value; ties are broken at random."""
        values = self.table[rows, places]
        if wrong is not None and self.actions > 1:
            values[np.arange(len(rows)), wrong] = -np.inf
        may = values == most(values)[:, None]
        epsilon = np.broadcast_to(self.parameter("epsilon", rows), rows.shape)
        bold = np.flatnonzero(epsilon > 0)
        if len(bold):
            explores = bold[self.streams.random(rows[bold]) < epsilon[bold]]
            may[explores] = values[explores] > -np.inf
        return self.drawn_from(may, rows)

    def take(self, rows: Ints, places: Ints, actions: Ints) -> None:
        """Note the states and the actions."""
        self._last[rows] = (rows * self.states + places) * self.actions + actions

    def teach(self, policy: Policy[Any], row: int, turn: int, seen: Sequence[Any], here: int) -> None:
        """Copy the memory of a row, including its table, into a policy; see `LearnerBatch.teach`."""
        super().teach(policy, row, turn, seen, here)
        place, action = divmod(int(self._last[row]) % (self.states * self.actions), self.actions)
        table = dict(zip(seen, self.table[row].tolist(), strict=True))
        policy.recall(table, seen[here], seen[place], action)  # type: ignore[attr-defined]  # a method of the q_learning policy
