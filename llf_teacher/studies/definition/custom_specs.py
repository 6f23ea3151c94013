"""Users' own teachers and students in a study, named by where they are defined: `my_package.my_module:Sleepy(naps=2)`.

A study contains only text, which a file can contain and other processes can read. So it names an object by module,
class and parameters, and the playing process imports the module. A name without a colon is one of the package's own.
"""

import importlib
from collections.abc import Iterable
from typing import Any

from llf_teacher.speakers.parsing import parse_teacher
from llf_teacher.speakers.speaker import Speaker, Voiced
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from teachers.personality import Personality, stages_of
from teachers.spec import paths_in

MAIN = "__main__"
"""The module of a program or a notebook, which no other process can import."""


def teacher_spec(teacher: Any) -> str:
    """The spec string of a teacher, given as a string or as an object.

    Raises:
        ValueError: there is no such teacher, or its spec string does not lead to it.
    """
    if callable(teacher) and not isinstance(teacher, Personality | Speaker):
        teacher = f"{teacher.__module__}:{_global(teacher)}"
    parsed = parse_teacher(teacher)
    personality = parsed.personality if isinstance(parsed, Voiced) else parsed
    for stage in stages_of(personality) if isinstance(personality, Personality) else ():
        _global(type(stage))
    text = f"{parsed}"
    try:
        found = parse_teacher(text)
    except ValueError as error:
        raise ValueError(f"teacher {teacher!r}: its spec {text!r} does not lead to it: {error}") from None
    if found != parsed:
        raise ValueError(
            f"teacher {teacher!r}: its spec {text!r} makes another; the parameters of a teacher in a study must be "
            "numbers, texts, or lists of them"
        )
    return text


def student_spec(student: Any) -> str:
    """The spec string of a student; a function or a class is the factory of an agent, as in `module:factory`.

    Raises:
        ValueError: there is no such student, or its spec string does not lead to it.
    """
    if callable(student) and not isinstance(student, Student):
        student = f"{student.__module__}:{_global(student)}"
    return str(parse_student(student))


def defined_in_main(specs: Iterable[str]) -> list[str]:
    """The specs of teachers and students that the main module defines."""
    return [spec for spec in specs if any(path.startswith(f"{MAIN}:") for path in paths_in(spec))]


def check_portable(specs: Iterable[str]) -> None:
    """Check that another process can make the teachers and students.

    Raises:
        ValueError: the main module defines some of them.
    """
    if found := defined_in_main(specs):
        raise ValueError(
            f"{', '.join(found)}: other processes cannot import what a program or a notebook defines; put it into a "
            "module and name that, as in 'my_module:MyClass', or play here, by workers=1 without limits, or by "
            "RunOptions('here')"
        )


def _global(thing: Any) -> str:
    """The name of a class or a function in its module."""
    name = getattr(thing, "__qualname__", "")
    if not name.isidentifier() or getattr(importlib.import_module(thing.__module__), name, None) is not thing:
        raise ValueError(f"{thing!r} cannot be found by its name; define it in a module, outside functions and classes")
    return str(name)
