"""Students with parameters that are drawn at random."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from llf_teacher.students.student import Student
from llf_teacher.students.trait import Traited
from teachers.spec import unknown

__all__ = ["check_vary", "draw_student", "is_integer_range"]


def draw_student(student: Student, vary: Mapping[str, Any], rng: np.random.Generator) -> Student:
    """A student with uniformly drawn parameters.

    Args:
        student: has the other parameters.
        vary: for each parameter the least and greatest value; between two integers it draws an integer, ends included.
        rng: draws once per parameter, in the order of their names.
    """
    values = {}
    for name in sorted(vary):
        low, high = vary[name]
        whole = is_integer_range(low, high)
        values[name] = int(rng.integers(low, high + 1)) if whole else float(rng.uniform(low, high))
    return dataclasses.replace(student, **values)


def is_integer_range(low: Any, high: Any) -> bool:
    """Whether an integer is drawn from this range."""
    return isinstance(low, int) and isinstance(high, int)


def check_vary(student: Any, vary: Mapping[str, Any]) -> None:
    """Check that students can be drawn.

    Raises:
        ValueError: a parameter is unknown, a range is not a pair of values, or one of its ends is not allowed.
    """
    if not isinstance(student, Student):
        raise ValueError(f"vary needs a student that is given by its spec, got {student!r}")
    if isinstance(student, Traited):
        raise ValueError(f"vary needs a student without traits, got {student}; allowed: {student.student}")
    names = [field.name for field in dataclasses.fields(student)]
    for name, ends in vary.items():
        if name not in names:
            raise ValueError(unknown(f"parameter of {student.name}", name, names))
        numbers = isinstance(ends, tuple | list) and all(type(end) in (int, float) for end in ends)
        if not numbers or len(ends) != 2 or ends[0] > ends[1]:
            raise ValueError(f"vary[{name!r}] must be the least and the greatest value, got {ends!r}")
        for end in ends:
            dataclasses.replace(student, **{name: end})
