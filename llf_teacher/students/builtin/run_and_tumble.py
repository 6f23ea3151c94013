"""run_and_tumble: repeats an action while rewards rise, for worlds in which actions accumulate."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import Trend
from teachers.spec import Share


class _Policy(Policy["RunAndTumble"]):
    """The last action and its reward."""

    def begin(self) -> None:
        """Begin an episode without memory."""
        space = self.action_box
        self._middle = (space.low + space.high) / 2
        self._reach = self.spec.size * (space.high - space.low) / 2
        self._action: np.ndarray | None = None
        self._reward = -np.inf

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The last action if the reward rose, else a random one."""
        if self._action is None or info["reward"] <= self._reward:
            turn = self.rng.uniform(-1, 1, self._middle.shape)
            self._action = (self._middle + turn * self._reach).astype(self._middle.dtype)
        self._reward = info["reward"]
        return self._action

    def did(self, action: Any) -> None:
        """Note the action, which replaces the last one."""
        self._action = action


@dataclass(frozen=True)
class RunAndTumble(Student):
    """Bacterial chemotaxis (Berg & Brown 1972): the same action while the reward rises, a random one when it falls.

    Actions stay near the middle of the box, since a bad action has effects beyond the turn that reveals it.
    """

    size: Share = 0.1
    """Maximum distance of an action from the middle of the box, as a fraction of half its width, 0 to 1."""
    reads = "reward"
    suits = Trend
    policy = _Policy
