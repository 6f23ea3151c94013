"""Teachers and students of a stored study for its report, without the modules of users' own."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from llf_teacher.speakers.parsing import parse_teacher
from llf_teacher.speakers.speaker import Speaker
from llf_teacher.students.parsing import parse_student
from llf_teacher.students.student import Student
from teachers.personality import Personality
from teachers.spec import parse_calls


class StoredFacts(NamedTuple):
    """The stored facts of a teacher or a student whose module cannot be imported here."""

    reads: str = "words"
    """What the student reads."""
    mute: bool = False
    """Whether the teacher says only the instruction."""


_stored: dict[str, StoredFacts] = {}


def facts_of(students: Iterable[str], teachers: Iterable[str]) -> dict[str, dict[str, Any]]:
    """The facts to store about users' own teachers and students, by spec, as JSON values."""
    reads = {spec: StoredFacts(reads=parse_student(spec).reads) for spec in students if is_own(spec)}
    mute = {spec: StoredFacts(mute=parse_teacher(spec).mute) for spec in teachers if is_own(spec)}
    return {spec: each._asdict() for spec, each in (reads | mute).items()}


def use_stored(facts: Mapping[str, Mapping[str, Any]]) -> None:
    """Use the results of `facts_of` for specs whose modules cannot be imported."""
    _stored.update({spec: StoredFacts(**each) for spec, each in facts.items()})


def student_of(spec: str) -> Student | StoredFacts:
    """The student of a spec; errors as in `parse_student`, except for missing modules."""
    try:
        return parse_student(spec)
    except ValueError:
        if not is_own(spec):
            raise
        return _stored.get(spec, StoredFacts())


def teacher_of(spec: str) -> Personality | Speaker | StoredFacts:
    """The teacher of a spec; errors as in `parse_teacher`, except for missing modules."""
    try:
        return parse_teacher(spec)
    except ValueError:
        if not is_own(spec):
            raise
        return _stored.get(spec, StoredFacts())


def is_own(spec: str) -> bool:
    """Whether a user's own module defines a part of a teacher or a student."""
    return any(call.prefix for call in parse_calls("teacher or student", spec, "a spec", prefixes=2))
