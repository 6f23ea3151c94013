"""Movies as LLF-Bench has them: a text without a list has no right title."""

from typing import ClassVar

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """A text without a list of titles earns the reward of a list without a right title."""

    failure_reward: ClassVar[float] = -1.0
