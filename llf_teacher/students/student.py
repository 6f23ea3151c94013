"""Students: policies for the student's seat, named by spec strings such as `q_learning(alpha=0.5)`.

A student is a frozen dataclass in a module of its name under `llf_teacher/students/shelf/`; a `Policy` beside it
plays. A policy knows the rules of the world (spaces, words), never its state, and reads what it says it reads.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from gymnasium import spaces

from llf_teacher.students import shelf
from pz_envs.learning import Learning
from pz_envs.seatings.tutoring import TutoringEnv
from pz_envs.seats import STUDENT
from pz_envs.subject import Subject
from teachers.atoms import ActionClaim, Claim, PlanClaim
from teachers.spec import Spec
from worlds.world import World

READS = ("nothing", "reward", "words", "atoms", "atoms and reward", "truth")
TAUGHT = ("words", "atoms", "atoms and reward")
"""What a student reads whom a teacher can reach."""


S_co = TypeVar("S_co", bound="Student", covariant=True)


class Policy(ABC, Generic[S_co]):
    """Plays in the student's seat: `reset(rng)`, then `act` once a turn.

    Args:
        spec: the student, for its parameters.
        family: the family of the environment.
        world: a scratch world of the environment's class and options, for its rules; it knows no episode.
    """

