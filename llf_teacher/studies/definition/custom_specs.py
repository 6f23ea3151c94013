"""Specs of the user's own teachers and students in a study, such as `my_package.my_module:Sleepy(naps=2)`.

A study holds text, which can be written to a file and read in another process. A spec with a colon names an object by
its module, its class and its parameters; the process that plays imports the module. A name without a colon is one of
the built-in registries'.
"""

import importlib
import io
import itertools
import tokenize
from collections.abc import Iterable, Iterator
from typing import Any

from llf_teacher.speakers.parsing import read_special
from llf_teacher.speakers.speaker import Quiet, Speaker, Voiced
from llf_teacher.students.agents import is_agent
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from teachers.feedback import parse_kinds
from teachers.personality import Personality, Pipeline, parse_personality, stages_of
from teachers.spec import import_call, unknown

MAIN = "__main__"
"""The running program, cells of a notebook included; other processes cannot import what is defined there."""


def parse_teacher(spec: str | Personality | Speaker) -> Personality | Speaker:
    """The teacher that a spec string describes; `package.module:Class(key=...)` is one of the user's own.

    It is a personality, a policy by its factory, `llm_teacher(...)`, or a personality with a voice, as in
    `oracle | voice(tone='curt')`.

    Raises:
        ValueError: bad syntax, an unknown name or parameter, or a module without such a teacher.
    """
    if isinstance(spec, Personality | Speaker):
        return spec
    if not isinstance(spec, str):
        return parse_personality(spec)
    *before, last = _parts(spec)
    special = read_special(last, last=bool(before))
    if isinstance(special, Speaker):
        return special
    if special is not None:
        return Voiced(_joined(before), special)
    return _joined([*before, last]) if ":" in spec else parse_personality(spec)


def _joined(parts: Iterable[str]) -> Personality:
    stages = [stage for part in parts for stage in stages_of(_one(part))]
    return stages[0] if len(stages) == 1 else Pipeline(tuple(stages))


def arguments_of(teacher: Personality | Speaker, feedback_type: str) -> dict[str, Any]:
    """The arguments of `llf_teacher.make` for a teacher; without feedback a policy only gives the instruction."""
    if isinstance(teacher, Personality):
        return {"teacher": teacher}
    arguments = teacher.arguments()
    if not isinstance(arguments["teacher"], Personality) and not parse_kinds(feedback_type):
        arguments["teacher"] = Quiet(arguments["teacher"])
    return arguments


def teacher_spec(teacher: Any) -> str:
    """The spec string of a teacher, which is given as text or as an object.

    Raises:
        ValueError: there is no such teacher, or no text describes it.
    """
    if callable(teacher) and not isinstance(teacher, Personality | Speaker):
        teacher = f"{teacher.__module__}:{_global(teacher)}"
    parsed = parse_teacher(teacher)
    text = _text(parsed)
    try:
        found = parse_teacher(text)
    except ValueError as error:
        raise ValueError(f"{teacher!r} cannot be made from its spec {text!r}: {error}") from None
    if found != parsed:
        raise ValueError(
            f"{teacher!r} is not equal to what its spec {text!r} makes; parameters of a teacher in a study must be "
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
        ValueError: there is no such student, or no text describes it.
    """
    if callable(student) and not isinstance(student, Student):
        student = f"{student.__module__}:{_global(student)}"
    return str(parse_student(student))


def defined_in_main(specs: Iterable[str]) -> list[str]:
    """The specs that name something in `MAIN`."""
    return [spec for spec in specs if any(part.split(":")[0].strip() == MAIN for part in _parts(spec) if ":" in part)]


def check_portable(specs: Iterable[str]) -> None:
    """Check that teachers and students can be made in another process.

    Raises:
        ValueError: some are defined in the running program.
    """
    if found := defined_in_main(specs):
        raise ValueError(
            f"{', '.join(found)}: other processes cannot import what a program or a notebook defines; put it into a "
            "module and name that, as in 'my_module:MyClass', or play in this process, by workers=1 without limits, or "
            "by RunOptions('here')"
        )


def _parts(spec: str) -> Iterator[str]:
    """The stages of a spec: its parts between each `|` outside of brackets and strings."""
    depth, start = 0, 0
    lines = [0, *itertools.accumulate(len(line) + 1 for line in spec.split("\n"))]  # the offset of each line
    try:
        for token in tokenize.generate_tokens(io.StringIO(spec).readline):
            depth += (token.string in ("(", "[", "{")) - (token.string in (")", "]", "}"))
            if token.type == tokenize.OP and token.string == "|" and not depth:
                at = lines[token.start[0] - 1] + token.start[1]
                yield spec[start:at]
                start = at + 1
    except (tokenize.TokenError, SyntaxError):
        pass  # the rest is one part, which is refused later
    yield spec[start:]


def _one(part: str) -> Personality:
    """The personality of one stage."""
    if not is_agent(part):
        return parse_personality(part.strip())
    module, name, values = import_call("teacher", "Class", part.strip())
    cls = getattr(module, name, None)
    if not (isinstance(cls, type) and issubclass(cls, Personality)):
        found = vars(module).items()
        names = [name for name, each in found if isinstance(each, type) and issubclass(each, Personality)]
        raise ValueError(f"teacher {part.strip()!r}: {unknown(f'personality in {module.__name__}', name, names)}")
    try:
        return cls(**values)
    except TypeError as error:
        raise ValueError(f"teacher {part.strip()!r}: {error}") from None


def _named(stage: Personality) -> str:
    """A stage as text, with its module if it is not built in."""
    on_shelf = type(stage).__module__.rpartition(".")[0] == stage.shelf
    return f"{stage}" if on_shelf else f"{type(stage).__module__}:{_global(type(stage))}{f'{stage}'[len(stage.name) :]}"


def _global(thing: Any) -> str:
    """The name of a thing in its module."""
    name = getattr(thing, "__qualname__", "")
    if not name.isidentifier() or getattr(importlib.import_module(thing.__module__), name, None) is not thing:
        raise ValueError(f"{thing!r} has no global name; define it in a module, outside of functions and classes")
    return str(name)
