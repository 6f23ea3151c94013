"""Poems as LLF-Bench has them: a text without a poem has no right line."""

from typing import ClassVar

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """A text without a poem earns the reward of a wrong number of lines."""

    failure_reward: ClassVar[float] = -1.0
