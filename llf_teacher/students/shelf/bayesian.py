"""bayesian: weighs a teacher's advice by how reliable it turns out to be, so that liars can be found out."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from llf_teacher.students.student import Policy, Student, action_of, frozen, state_of
from pz_envs.subject import Subject
from teachers.atoms import FN, FP, HN, HP
from teachers.spec import check_range
from worlds.world import World

_STEADY = 0.75  # chance with which a teacher says what it believes rather than anything
_SWEEPS = 4
_DRAWS = 256
_ADVICE, _WARNING, _VERDICT = range(3)  # what a teacher may be good at: fp, fn, and hp with hn


class _Policy(Policy["Bayesian"]):
    """Infers anew each turn; the posterior is `best`, the skills are `skill`."""

