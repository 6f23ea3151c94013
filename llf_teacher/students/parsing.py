"""Students by their spec strings, and by what there is to learn."""

from dataclasses import asdict

from llf_teacher.students import builtin
from llf_teacher.students.agents import is_agent, parse_agent
from llf_teacher.students.chat import is_chat, parse_chat
from llf_teacher.students.student import Student
from pz_envs.learning import Learning
from teachers.spec import Shelf

STUDENTS = Shelf[Student]("student", Student, builtin)  # type: ignore[type-abstract]  # the shelf makes none itself
"""Every student by its name."""


def parse_student(spec: str | Student) -> Student:
    """The student that a spec string describes.

    `package.module:factory` is an agent of the user's own, `chat:package.module:function` a function that answers.

    Raises:
        ValueError: an unknown name or parameter, or bad syntax; the message says what is allowed.
    """
    if isinstance(spec, Student):
        return spec
    if is_chat(spec):
        return parse_chat(spec)
    if is_agent(spec):
        return parse_agent(spec)
    parsed = STUDENTS.parse(spec)
    if len(parsed) != 1:
        raise ValueError(f"student spec {spec!r} names {len(parsed)} students; allowed: one")
    return parsed[0]


def student_for(learning: Learning) -> Student:
    """The student who learns what rewards alone teach.

    Raises:
        ValueError: none does.
    """
    for name in STUDENTS.names:
        cls = STUDENTS[name]
        if cls.suits is type(learning):
            return cls(**asdict(learning))
    raise ValueError(f"no student learns from {learning!r}; one that does says so by its `suits`")
