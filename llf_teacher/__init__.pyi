from llf_teacher.gym import StudentEnv, TeacherEnv, TeacherVectorEnv, make, prompt, teach
from llf_teacher.registry import ids, supported_types
from pz_envs.lesson import Lesson
from worlds.wrapped.old_gym import OldGym

__version__: str
__all__ = [
    "Lesson",
    "OldGym",
    "StudentEnv",
    "TeacherEnv",
    "TeacherVectorEnv",
    "ids",
    "make",
    "prompt",
    "supported_types",
    "teach",
]
