"""LLF-Bench's `agents.abstract_agent`: base classes for users' own agents."""

from typing import Any

from llf_teacher.compat.agent_utils import ReplayBuffer

__all__ = ["Agent", "BasicAgent"]


class AbstractAgent:
    """Answers observations and feedback; a subclass defines `act`."""

    NAME = "AbstractAgent"

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.docstring: str | None = None

    def reset(self, docstring: str) -> None:
        """Begin an episode with an instruction."""
        self.docstring = docstring

    def act(self, *args: Any, **kwargs: Any) -> Any:
        """The action after an observation and feedback."""
        raise NotImplementedError(f"{type(self).__name__} must have act(observation, feedback)")


Agent = AbstractAgent
"""LLF-Bench's name for `AbstractAgent`."""


class BasicAgent(AbstractAgent):
    """An agent with a buffer of records, which `reset` empties.

    Args:
        verbose: whether it prints what it does.
        buffer_size: greatest number of records.
        prompt_template: kept for the subclass.
    """

    NAME = "BasicAgent"

    def __init__(self, verbose: bool = False, buffer_size: int = 1000, prompt_template: str | None = None) -> None:
        super().__init__()
        self.verbose, self.prompt_template = verbose, prompt_template
        self.buffer = ReplayBuffer(buffer_size)

    def reset(self, docstring: str) -> None:
        """Begin an episode with an instruction and an empty buffer."""
        super().reset(docstring)
        self.buffer.reset()
