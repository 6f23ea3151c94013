"""Students by their spec strings, and by what there is to learn."""

from dataclasses import asdict

from llf_teacher.students import builtin
from llf_teacher.students.agents import make_agent
from llf_teacher.students.chat import CHAT, make_chat_student
from llf_teacher.students.student import Student
from pz_envs.learning import Learning
from teachers.spec import Registry, bad_spec, parse_call

STUDENTS = Registry[Student]("student", Student, builtin)  # type: ignore[type-abstract]  # it never makes a `Student`
"""Every student by its name."""


def parse_student(spec: str | Student) -> Student:
    """The student that a spec string describes.

    `package.module:factory` is an agent of the user's own, `chat:package.module:function` a function that answers
    prompts; these import the module.

    Raises:
        ValueError: bad syntax, or an unknown name, module or parameter.
    """
    if isinstance(spec, Student):
        return spec
    expected = f"`package.module:factory`, `{CHAT}:package.module:function`, or {STUDENTS.expected}"
    call = parse_call("student", spec, expected, prefixes=2)
    if not call.prefix:
        return STUDENTS.make(call)
    if call.prefix[0] == CHAT:
        return make_chat_student(call)
    if len(call.prefix) > 1:
        raise bad_spec("student", spec, expected)
    return make_agent(call)


def student_for(learning: Learning) -> Student:
    """The student that learns from rewards alone with these settings.

    Raises:
        ValueError: no student does.
    """
    for name in STUDENTS.names:
        cls = STUDENTS[name]
        if cls.suits is type(learning):
            return cls(**asdict(learning))
    raise ValueError(f"no student learns from {learning!r}; `suits` of a student names what it learns from")
