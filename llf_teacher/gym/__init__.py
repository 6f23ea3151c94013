"""Gymnasium's views of the two seats, and the functions that make them."""

from llf_teacher.gym.make import make
from llf_teacher.gym.student_env import StudentEnv
from llf_teacher.gym.teach import prompt, teach
from llf_teacher.gym.teacher_env import TeacherEnv
from llf_teacher.gym.vector import TeacherVectorEnv

__all__ = ["StudentEnv", "TeacherEnv", "TeacherVectorEnv", "make", "prompt", "teach"]
