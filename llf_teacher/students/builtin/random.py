"""random: takes random actions; the lower bound in every study."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.student import Policy, Student
from pz_envs.learning import NoRewards


class _Policy(Policy["Random"]):
    """Draws one of the world's actions."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """A random legal action, from the admissible actions if the environment lists them."""
        listed = info.get(self.world.actions_key)
        return listed[self.rng.integers(len(listed))] if listed else self.world.sample_action(self.rng)


@dataclass(frozen=True)
class Random(Student):
    """Takes random actions."""

    reads = "nothing"
    suits = NoRewards
    policy = _Policy
