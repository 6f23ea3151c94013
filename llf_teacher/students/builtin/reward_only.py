"""reward_only: learns from rewards alone, by the method that suits the family."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.parsing import student_for
from llf_teacher.students.student import Policy, Student
from pz_envs.subject import Subject
from worlds.world import World


@dataclass(frozen=True)
class RewardOnly(Student):
    """Learns from rewards alone, as the student that the family names."""

    reads = "reward"

    def seat(self, family: Subject, world: World[Any]) -> Policy[Any]:
        """The policy of the named student."""
        return student_for(family.learning).seat(family, world)
