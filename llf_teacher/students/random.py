"""random: tries any action; the floor of every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.student import Policy, Student


@dataclass(frozen=True)
class Random(Student):
    """Acts without regard to anything."""

    reads = "nothing"

    class Policy(Policy):
        """Draws what the world offers as an untaught student's try."""

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """A random legal action."""
            return self.world.sample_action(self.rng)
