"""random_search: tries random actions, then repeats the best, for worlds without a state."""

import math
from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import BestAnswer
from teachers.spec import check_range


class _Policy(Policy["RandomSearch"]):
    """The best action so far."""

    def begin(self) -> None:
        """Begin an episode without memory."""
        self._best: Any = None
        self._reward = -math.inf
        self._last: Any = None
        self._tried = 0

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """Another random action, or the best."""
        if self._tried and info["reward"] > self._reward:
            self._best, self._reward = self._last, info["reward"]
        if self._tried < self.spec.tries and self._reward < self.world.reward_range[1]:
            self._tried += 1
            self._last = self.world.sample_action(self.rng)
        else:
            self._last = self._best
        return self._last

    def did(self, action: Any) -> None:
        """Note the answer, which replaces the last one."""
        self._last = action


@dataclass(frozen=True)
class RandomSearch(Student):
    """Tries random actions, at most until the maximum reward, then repeats the best."""

    tries: int = 10
    """Number of random actions, at least 1."""
    reads = "reward"
    suits = BestAnswer
    policy = _Policy

    def __post_init__(self) -> None:
        check_range("tries", self.tries, 1, math.inf)
