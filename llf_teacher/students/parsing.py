"""Students by their spec strings."""

from llf_teacher.students import shelf
from llf_teacher.students.agents import is_agent, parse_agent
from llf_teacher.students.student import Student
from teachers.spec import Shelf

STUDENTS = Shelf("student", Student, shelf)
"""Every student by its name."""


def parse_student(spec: str | Student) -> Student:
    """The student that a spec string describes; `package.module:factory` is an agent of the user's own.

    Raises:
        ValueError: an unknown name or parameter, or bad syntax; the message says what is allowed.
    """
    if isinstance(spec, Student):
        return spec
    if is_agent(spec):
        return parse_agent(spec)
    parsed = STUDENTS.parse(spec)
    if len(parsed) != 1:
        raise ValueError(f"student spec {spec!r} names {len(parsed)} students; allowed: one")
    return parsed[0]
