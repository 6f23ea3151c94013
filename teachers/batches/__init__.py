"""Oracles for many worlds at once, in arrays. Each family's oracle is in the module of its name."""

from abc import ABC, abstractmethod
from typing import Any, Generic, NamedTuple

import numpy as np
import numpy.typing as npt

from teachers.oracle import Oracle, RefusalError
from worlds.batches import Bools, Floats, Ints, Rows, StateT, WorldBatch, chosen, most

__all__ = ["Kinds", "Moments", "OracleBatch", "Said", "Stakes", "subset"]

Kinds = npt.NDArray[np.uint8]
"""Subsets of the kinds, of shape (rows,): bit i for kind i."""
_NEAR = 1e-9  # differences below this are rounding


class Moments(NamedTuple, Generic[StateT]):
    """Moments in arrays, one row each; see `teachers.atoms.Moment`."""

    before: StateT
    """The worlds' state before the actions; undefined in rows at an opening, with turn 0."""
    action: npt.NDArray[Any]
    reward: Floats
    after: StateT
    success: Bools
    turn: Ints
    over: Bools

    def taken(self, worlds: WorldBatch[Any, StateT], rows: Rows) -> "Moments[StateT]":
        """The moments of these rows."""
        before, after = worlds.taken(self.before, rows), worlds.taken(self.after, rows)
        reward, success, turn, over = self.reward[rows], self.success[rows], self.turn[rows], self.over[rows]
        return Moments(before, self.action[rows], reward, after, success, turn, over)


class Said(NamedTuple):
    """The claims about moments, one row each."""

    kinds: Kinds
    """The kinds of the claims."""
    advised: npt.NDArray[Any]
    """The advised action (fp); undefined in rows without advice."""
    warned: npt.NDArray[Any]
    """The action of the warning (fn); undefined in rows without a warning."""
    verdicts: npt.NDArray[Any] | None = None
    """Numbers of verdicts of kinds hp and hn, shape (rows, 2); None: one of each kind in `kinds`."""
    judges: npt.NDArray[Any] | None = None
    """Whether hp and hn name the action, bool of shape (rows, 2); None: they do."""


class Stakes:
    """What is at stake in states, one row each, by the values of actions.

    Args:
        values: the value of each action, shape (rows, actions).
        limit: greatest importance.
    """

    def __init__(self, values: Floats, limit: float) -> None:
        self.values, self._best = values, most(values)
        self.importance = np.minimum(self._best + most(-values), limit)
        """Value of the best action minus that of the worst, of shape (rows,)."""

    def regret(self, moments: Moments[Any]) -> Floats:
        """Regret of the moments' actions, which were taken in these states, shape (rows,)."""
        lost: Floats = self._best - chosen(self.values, moments.action)
        return lost

    def mistakes(self, actions: Ints) -> Bools:
        """Whether these actions are worth less than others, of shape (rows,)."""
        worse: Bools = chosen(self.values, actions) < self._best - _NEAR
        return worse


class OracleBatch(ABC, Generic[StateT]):
    """A family's oracle in arrays. It states at most one claim of each kind about an action.

    Args:
        oracle: an oracle for the worlds of the batch.
        worlds: the worlds that it judges.
    """

    def __init__(self, oracle: Oracle[Any, Any], worlds: WorldBatch[Any, StateT]) -> None:
        self.oracle, self.worlds = oracle, worlds

    @abstractmethod
    def judge(self, moments: Moments[StateT]) -> Said:
        """All true claims, as in `Oracle.judge`."""

    def values(self, state: StateT) -> Floats:
        """Value per discrete action, shape (rows, actions), as in `Oracle.values`."""
        raise RefusalError(f"{type(self).__name__} gives no values")

    def stakes(self, state: StateT) -> Stakes:
        """What is at stake, as in `Oracle.importance` and `Oracle.regret`."""
        return Stakes(self.values(state), self.oracle.max_importance)

    def plan_length(self, state: StateT, n: int) -> Ints:
        """The number of actions in `Oracle.plan`, shape (rows,)."""
        raise RefusalError(f"{type(self).__name__} has no plan")


def subset(r: Bools, hp: Bools, hn: Bools, fp: Bools, fn: Bools) -> Kinds:
    """The subset of the kinds that are true in each row."""
    total = np.zeros(len(r), np.uint8)
    for bit, said in enumerate((r, hp, hn, fp, fn)):
        total |= said.view(np.uint8) << np.uint8(bit)
    return total
