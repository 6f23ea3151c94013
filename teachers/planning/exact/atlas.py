"""What the exact tier knows of an environment."""

from collections.abc import Callable
from typing import Any

import gymnasium

from teachers.planning.exact.worths import Worths
from teachers.planning.transitions import Transitions
from worlds.wrapped.gym_world import GymWorld, Position

_KEPT = 16  # explored episodes


class Atlas:
    """The values of all states, computed once, or anew for each episode whose states are not known yet.

    Args:
        transitions: those that are known.
        solve: computes the values.
        explore: the transitions of the states that an environment can reach, given the number of actions so far; None:
            all are known.
    """

    def __init__(
        self,
        transitions: Transitions,
        solve: Callable[[Transitions], Worths],
        explore: Callable[[gymnasium.Env[Any, Any], int], Transitions] | None = None,
    ) -> None:
        self._solve, self._explore = solve, explore
        self._known = [solve(transitions)]
        self.horizon, self.gamma, self.actions = self._known[0].horizon, self._known[0].gamma, self._known[0].actions

    @property
    def spread(self) -> float:
        """The greatest difference between two actions in any known state."""
        return max(values.spread for values in self._known)

    @property
    def explores(self) -> bool:
        """Whether states are explored that are not known yet."""
        return self._explore is not None

    @property
    def size(self) -> int:
        """The number of states that are known, those after the end included."""
        return max(len(values.transitions) for values in self._known)

    @property
    def certain(self) -> bool:
        """Whether nothing is left to chance."""
        return all(values.certain for values in self._known)

    def at(self, truth: Position, lab: GymWorld) -> Worths:
        """The values of the states around a truth; the lab goes there if they have to be explored.

        Raises:
            PlanningError: the episode has more states than are allowed.
        """
        for values in self._known:
            if truth.seen in values:
                return values
        if self._explore is None:
            return self._known[0]
        lab.restore(truth)
        values = self._solve(self._explore(lab.env, truth.turn))
        self._known = [values, *self._known[: _KEPT - 1]]
        return values
