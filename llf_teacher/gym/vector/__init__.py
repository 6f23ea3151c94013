"""Thousands of lessons at once: the seats as Gymnasium's vector environments, in arrays."""

from llf_teacher.gym.vector.student import StudentVectorEnv
from llf_teacher.gym.vector.teacher import TeacherVectorEnv

__all__ = ["StudentVectorEnv", "TeacherVectorEnv"]
