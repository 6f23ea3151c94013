"""Movies as LLF-Bench has them: what is no list names nothing that is right."""

from typing import ClassVar

from llf_teacher.compat.env import LLFEnv


class Surface(LLFEnv):
    """A text that is no list of titles earns what a list without a right title does."""

    failure_reward: ClassVar[float] = -1.0
