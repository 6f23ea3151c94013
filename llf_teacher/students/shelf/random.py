"""random: tries any action; the floor of every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import NoRewards


@dataclass(frozen=True)
class Random(Student):
    """Acts without regard to anything."""

    reads = "nothing"
    suits = NoRewards

    class Policy(Policy):
        """Draws from the actions that the info lists, or else from those that the world would try."""

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """A random legal action; of those that come to something now, where the world tells which they are."""
            listed = info.get(self.world.actions_key)
            return listed[self.rng.integers(len(listed))] if listed else self.world.sample_action(self.rng)
