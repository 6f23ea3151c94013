"""reward_only: the learner from rewards alone that suits the family."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.students.parsing import student_for
from llf_teacher.students.student import Policy, Student
from pz_envs.subject import Subject
from worlds.world import World


@dataclass(frozen=True)
class RewardOnly(Student):
    """Plays as the student who suits what rewards alone teach in the family."""

    reads = "reward"

    def seat(self, family: Subject, world: World[Any]) -> Policy[Any]:
        """The named student's policy."""
        return student_for(family.learning).seat(family, world)
