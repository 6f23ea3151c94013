"""Poems as LLF-Bench has them: what is no poem has no line that is right."""

from typing import ClassVar

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """A text that cannot be read as a poem earns what a wrong number of lines does."""

    failure_reward: ClassVar[float] = -1.0
