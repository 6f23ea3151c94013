"""metaworld's own environment, for benchmarks."""

import pickle
import sys
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np

from worlds.metaworld.state import FloatArray


class Original(gymnasium.Env[Any, Any]):
    """metaworld's unmodified environment; a step makes all low-level steps of the next turn."""

    def __init__(self, task: str, variation: Sequence[float], turns: list[list[FloatArray]]) -> None:
        from metaworld.env_dict import ALL_V3_ENVIRONMENTS
        from metaworld.types import Task

        cls = ALL_V3_ENVIRONMENTS[task]
        self.env = cls()
        self.env.max_path_length = sys.maxsize
        settings = {"env_cls": cls, "rand_vec": np.array(variation), "partially_observable": False}
        self.env.set_task(Task(task, pickle.dumps(settings)))
        self._turns = turns

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin the episode anew."""
        self._next = iter(self._turns)
        return self.env.reset()

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Make the low-level steps of the next turn, whose action is `action`."""
        result: tuple[Any, Any, bool, bool, dict[str, Any]]
        for command in next(self._next):
            result = self.env.step(command)
        return result
