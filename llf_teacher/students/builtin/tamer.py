"""tamer: predicts the trainer's label of each action, and takes the action of the greatest prediction."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llf_teacher.students.evaluated import Evaluated, EvaluatedPolicy, Features, Table
from teachers.spec import Share


class _Policy(EvaluatedPolicy["Tamer"]):
    """A table of expected labels."""

    def clear(self) -> None:
        """Forget all labels."""
        self._human = Table(self.actions)

    def hear(self, turn: int, label: float) -> None:
        """A step towards the label; silence is not a label."""
        state, action = self.steps[turn - 1]
        if label:
            self._human.add(state, self.spec.alpha * (label - self._human(state)[action]), action)

    def recall(self, table: Mapping[Hashable, NDArray[np.float64]]) -> None:
        """Take over a memory: predictions per state, shape (actions,)."""
        for state, row in table.items():
            self._human.add((state,), row)

    def choose(self, here: Features) -> int:
        """The action of the greatest prediction; labels are not summed like rewards, so the horizon is one action."""
        return self.best(self._human(here))


@dataclass(frozen=True)
class Tamer(Evaluated):
    """TAMER (Knox & Stone 2009): supervised learning of the trainer's praise (1) and blame (-1), and greedy actions.

    The paper has linear functions of features, and spreads a label over the last actions by a density of the trainer's
    delay. Here there is a table, or tiles, and a label says which turn it is about.
    """

    alpha: Share = 0.3
    """Step size, 0 to 1."""
    reads = "atoms"
    policy = _Policy
    batch = "Tamers"
