"""Vector environments of both seats in arrays, for thousands of lessons at once."""

from llf_teacher.gym.vector.student import StudentVectorEnv
from llf_teacher.gym.vector.teacher import TeacherVectorEnv

__all__ = ["StudentVectorEnv", "TeacherVectorEnv"]
