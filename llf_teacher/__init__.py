"""Learning from language feedback: `make` environments with teachers, run studies, train teachers.

Importing this package registers every environment with Gymnasium and PettingZoo and loads no simulator.
"""

from importlib import import_module

import llf_teacher.import_check  # noqa: F401 (checks that the packages beside this one are ours)
from llf_teacher.registry import ids, register_all, supported_types

__version__ = "0.2.0"
__all__ = [
    "Conversation", "Lesson", "OldGym", "StudentEnv", "TeacherEnv", "TeacherVectorEnv",
    "chat_student", "ids", "make", "prompt", "rollout", "supported_types", "teach",
]  # fmt: skip

register_all()


def __getattr__(name: str) -> object:  # `__init__.pyi` has the types
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    lazy_exports = {"Lesson": "pz_envs.lesson", "OldGym": "worlds.wrapped.old_gym"}
    lazy_exports |= {"Conversation": "llf_teacher.students.conversation", "chat_student": "llf_teacher.students.chat"}
    lazy_exports |= {"rollout": "llf_teacher.episodes.rollout"}
    return getattr(import_module(lazy_exports.get(name, "llf_teacher.gym")), name)


def __dir__() -> list[str]:
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])
