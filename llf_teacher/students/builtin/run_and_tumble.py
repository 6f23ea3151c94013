"""run_and_tumble: keeps to what makes rewards rise, else tries something new, for worlds in which actions add up."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import Trend
from teachers.spec import check_range


class _Policy(Policy["RunAndTumble"]):
    """Holds the action and what it earned."""

    def begin(self) -> None:
        """Have tried nothing."""
        space = self.action_box
        self._middle = (space.low + space.high) / 2
        self._reach = self.spec.size * (space.high - space.low) / 2
        self._action: np.ndarray | None = None
        self._reward = -np.inf

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Run or tumble."""
        if self._action is None or info["reward"] <= self._reward:
            turn = self.rng.uniform(-1, 1, self._middle.shape)
            self._action = (self._middle + turn * self._reach).astype(self._middle.dtype)
        self._reward = info["reward"]
        return self._action


@dataclass(frozen=True)
class RunAndTumble(Student):
    """How bacteria find food (Berg & Brown 1972): the same action while the reward rises, a random one when it falls.

    Actions stay near the middle of the box, since they go on to have an effect after it is seen that they are wrong.
    """

    size: float = 0.1
    """Greatest distance of an action from the middle of the box, as a share of half of its width, 0 to 1."""
    reads = "reward"
    suits = Trend
    policy = _Policy

    def __post_init__(self) -> None:
        check_range("size", self.size, 0, 1)
