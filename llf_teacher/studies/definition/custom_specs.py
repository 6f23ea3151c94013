"""Users' own teachers and students in a study, named by where they are defined: `my_package.my_module:Sleepy(naps=2)`.

A study contains only text, which a file can contain and other processes can read. So it names an object by module,
class and parameters, and the playing process imports the module. A name without a colon is one of the package's own.
"""

import importlib
from collections.abc import Iterable
from typing import Any

from llf_teacher.speakers.parsing import SPEAKERS, make_speaker
from llf_teacher.speakers.speaker import InstructionOnly, Speaker, Voiced
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from teachers.feedback import parse_kinds
from teachers.personality import PERSONALITIES, Personality, Pipeline, stages_of
from teachers.spec import SpecCall, parse_calls, unknown

MAIN = "__main__"
"""The module of a program or a notebook, which no other process can import."""


def parse_teacher(spec: str | Personality | Speaker) -> Personality | Speaker:
    """The teacher that a spec string describes.

    It is a personality, `llm_teacher(...)`, a user's own teacher as `package.module:Class(key=...)` (a personality, or
    the factory of a policy), or a personality with a voice, as in `oracle | voice(tone='curt')`.

    Raises:
        ValueError: bad syntax, an unknown name or parameter, or a module without such a teacher.
    """
    if isinstance(spec, Personality | Speaker):
        return spec
    expected = f"`package.module:Class(key=value)` or {PERSONALITIES.expected}, {', '.join(SPEAKERS)}"
    *before, last = parse_calls("teacher", spec, expected, prefixes=1)
    made = make_speaker(last, last=bool(before))
    if isinstance(made, Speaker):
        return made
    if made is not None:
        return Voiced(_personality(before), made)
    return _personality([*before, last])


def _personality(calls: Iterable[SpecCall]) -> Personality:
    stages = tuple(map(_stage, calls))
    return stages[0] if len(stages) == 1 else Pipeline(stages)


def _stage(call: SpecCall) -> Personality:
    if not call.prefix:
        return PERSONALITIES.make(call)
    module, cls = call.imported("teacher")
    if not (isinstance(cls, type) and issubclass(cls, Personality)):
        found = vars(module).items()
        names = [name for name, each in found if isinstance(each, type) and issubclass(each, Personality)]
        raise ValueError(f"teacher {call.path!r}: {unknown(f'personality in {module.__name__}', call.name, names)}")
    return call.make("teacher", cls)


def arguments_of(teacher: Personality | Speaker, feedback_type: str) -> dict[str, Any]:
    """The arguments of `llf_teacher.make` for a teacher; with feedback type `n` a policy gives only the instruction."""
    if isinstance(teacher, Personality):
        return {"teacher": teacher}
    arguments = teacher.arguments()
    if not isinstance(arguments["teacher"], Personality) and not parse_kinds(feedback_type):
        arguments["teacher"] = InstructionOnly(arguments["teacher"])
    return arguments


def teacher_spec(teacher: Any) -> str:
    """The spec string of a teacher, given as a string or as an object.

    Raises:
        ValueError: there is no such teacher, or its spec string does not lead to it.
    """
    if callable(teacher) and not isinstance(teacher, Personality | Speaker):
        teacher = f"{teacher.__module__}:{_global(teacher)}"
    parsed = parse_teacher(teacher)
    text = _text(parsed)
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


def _text(teacher: Personality | Speaker) -> str:
    if isinstance(teacher, Voiced):
        return f"{_text(teacher.personality)} | {teacher.wording}"
    return f"{teacher}" if isinstance(teacher, Speaker) else " | ".join(map(_named, stages_of(teacher)))


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

    def in_main(spec: str) -> bool:
        calls = parse_calls("teacher or student", spec, "the spec of a teacher or a student", prefixes=2)
        return any(call.prefix[:1] == (MAIN,) for call in calls)

    return list(filter(in_main, specs))


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


def is_ours(stage: Personality) -> bool:
    """Whether a personality is one of this package's."""
    return type(stage).__module__.rpartition(".")[0] == stage.package


def _named(stage: Personality) -> str:
    """The spec string of a stage, with its module if it is not in the package of personalities."""
    if is_ours(stage):
        return f"{stage}"
    return f"{type(stage).__module__}:{_global(type(stage))}{f'{stage}'[len(stage.name) :]}"


def _global(thing: Any) -> str:
    """The name of a class or a function in its module."""
    name = getattr(thing, "__qualname__", "")
    if not name.isidentifier() or getattr(importlib.import_module(thing.__module__), name, None) is not thing:
        raise ValueError(f"{thing!r} cannot be found by its name; define it in a module, outside functions and classes")
    return str(name)
