"""Learning from language feedback: `make` environments with teachers, run studies, train teachers.

Importing this package registers every environment with Gymnasium and PettingZoo and loads no simulator.
"""

from llf_teacher.registry import ids, make, register_all, supported_types

__version__ = "0.1.0"
__all__ = ["Lesson", "OldGym", "StudentEnv", "TeacherEnv", "ids", "make", "prompt", "supported_types", "teach"]

register_all()


def __getattr__(name: str) -> object:
    if name in __all__:
        from llf_teacher import gym_adapter

        return getattr(gym_adapter, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
