"""random: tries any action; the floor of every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import NoRewards


class _Policy(Policy["Random"]):
    """Draws what the world offers as an untaught student's try."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """A random legal action; of the admissible ones, where the environment tells which they are."""
        listed = info.get(self.world.actions_key)
        return listed[self.rng.integers(len(listed))] if listed else self.world.sample_action(self.rng)


@dataclass(frozen=True)
class Random(Student):
    """Acts without regard to anything."""

    reads = "nothing"
    suits = NoRewards
    policy = _Policy
