"""Parking as LLF-Bench has it: highway-env's observation."""

from typing import Any

from gymnasium import spaces

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """The observation is highway-env's dict of arrays."""

    def _observations(self) -> spaces.Space[Any]:
        space: spaces.Space[Any] = self._world.observation_space
        return space

    def _observe(self, text: str) -> Any:
        return self._world.observe()
