"""Optimization as LLF-Bench has it: points are proposed in words."""

from typing import Any, ClassVar

from gymnasium import spaces

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """The action space is one of texts such as `x = [1, 2]`; arrays are understood, too."""

    failure_reward: ClassVar[float] = -0.01

    def _actions(self) -> spaces.Space[Any]:
        return self._student.action_space
