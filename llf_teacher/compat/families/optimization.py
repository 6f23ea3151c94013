"""Optimization as LLF-Bench has it: actions are texts."""

from typing import Any, ClassVar

from gymnasium import spaces

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """The action space contains texts such as `x = [1, 2]`; `step` also takes arrays."""

    failure_reward: ClassVar[float] = -0.01

    def _actions(self) -> spaces.Space[Any]:
        return self._student.action_space
