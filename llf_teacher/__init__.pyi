from llf_teacher.episodes.rollout import rollout
from llf_teacher.gym import StudentEnv, TeacherEnv, TeacherVectorEnv, make, prompt, teach
from llf_teacher.registry import ids, supported_types
from llf_teacher.students.chat import chat_student
from llf_teacher.students.conversation import Conversation
from pz_envs.lesson import Lesson
from worlds.wrapped.old_gym import OldGym

__version__: str
__all__ = [
    "Conversation",
    "Lesson",
    "OldGym",
    "StudentEnv",
    "TeacherEnv",
    "TeacherVectorEnv",
    "chat_student",
    "ids",
    "make",
    "prompt",
    "rollout",
    "supported_types",
    "teach",
]
