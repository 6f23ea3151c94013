"""reward_only: the learner from rewards alone that suits the family."""

from dataclasses import dataclass

from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Policy, Student
from pz_envs.subject import Subject
from worlds.world import World


@dataclass(frozen=True)
class RewardOnly(Student):
    """Plays as the student that the family's declaration names: what rewards alone can teach."""

    reads = "reward"

    def seat(self, family: Subject, world: World) -> Policy:
        """The named student's policy."""
        return parse_student(family.reward_only).seat(family, world)
