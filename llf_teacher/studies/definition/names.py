"""Short names of teachers and students in reports: given by the study, or made of distinguishing parameters."""

import contextlib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

from llf_teacher.speakers.speaker import Voiced
from llf_teacher.students.student import Student
from llf_teacher.students.trait import Trait, traits_of
from llf_teacher.studies.definition.custom_specs import student_spec, teacher_spec
from teachers.atoms import KINDS
from teachers.feedback import parse_kinds
from teachers.personality import Personality, stages_of
from teachers.spec import call_string, parse_calls, unknown
from teachers.words import KIND_WORDS

LONGEST = 60
"""Greatest number of characters of a name."""
_ALWAYS, _WHERE = ("model",), ("base_url", "endpoint")


def check_names(given: Any, known: Iterable[str], problems: list[str]) -> dict[str, str]:
    """The table `names`, of names by spec, in canonical form; adds to `problems`."""
    known = dict.fromkeys(known)
    if not isinstance(given, Mapping):
        problems.append(f"names must be a table of specs with their names, got {given!r}")
        return {}
    names = {_canonical(spec, known): name for spec, name in given.items()}
    problems += [f"names: {unknown('teacher or student', spec, known)}" for spec in names if spec not in known]
    for name in names.values():
        if not isinstance(name, str) or not name.strip() or len(name) > LONGEST or not name.isprintable():
            problems.append(f"names: a name must be a text of 1 to {LONGEST} printable characters, got {name!r}")
    taken = Counter([*map(str, names.values()), *(spec for spec in known if spec not in names)])
    problems += [
        f"names: a name must be unique, got {name!r} several times" for name, count in taken.items() if count > 1
    ]
    return names


def _canonical(spec: str, known: Iterable[str]) -> str:
    """A spec in the study's form."""
    for canonical in (teacher_spec, student_spec):
        with contextlib.suppress(ValueError, TypeError):
            if (found := canonical(spec)) in known:
                return found
    return spec


def short_names(specs: Mapping[str, Any], given: Mapping[str, str]) -> dict[str, str]:
    """A name for each spec.

    A given name counts. Teachers and students that ask a model are called, for example, `llm(gpt-4o)`, with the
    parameters that differ between those of the same model; others are called by their spec, in which teachers and
    traits show the strength that they have without being asked, as in `mistake(eps=0.1)`, and kinds are words.

    Args:
        specs: the objects by their specs.
        given: names by spec.
    """
    models: dict[tuple[str, str], dict[str, Any]] = {}
    for spec, value in specs.items():
        asks: Any = value.wording if isinstance(value, Voiced) else value
        traits: tuple[Trait, ...] = ()
        if isinstance(value, Student):
            asks, traits = traits_of(value)
        if spec not in given and getattr(asks, "model", None):
            before = f"{value.personality} | " if isinstance(value, Voiced) else ""
            behind = "".join(f" | {trait}" for trait in traits)
            models.setdefault((f"{before}{asks.name}({asks.model}", behind), {})[spec] = asks
    found = {spec: shown_spec(spec, value) for spec, value in specs.items()} | dict(given)
    for (head, behind), alike in models.items():
        names = [field.name for field in fields(next(iter(alike.values()))) if field.name not in _ALWAYS]
        apart = [name for name in names if len({repr(getattr(value, name)) for value in alike.values()}) > 1]
        shown = [name for name in apart if name not in _WHERE] or apart
        for spec, value in alike.items():
            found[spec] = ", ".join([head, *(f"{name}={getattr(value, name)!r}" for name in shown)]) + f"){behind}"
    taken = Counter(found.values())
    return {spec: name if taken[name] == 1 else spec for spec, name in found.items()}


def shown_spec(spec: str, value: Any) -> str:
    """A spec as reports show it, which makes the same teacher or student.

    Args:
        spec: in the study's form.
        value: what it makes; its parts are those of the spec, in the same order.
    """
    if isinstance(value, Student):
        parts: list[Any] = [None, *traits_of(value)[1]]
    elif isinstance(value, Voiced):
        parts = [*stages_of(value.personality), None]
    else:
        parts = [*stages_of(value)] if isinstance(value, Personality) else [None]
    calls = parse_calls("teacher or student", spec, "a spec", prefixes=2)
    if len(calls) != len(parts):  # a student that is a program's own may have traits of its own
        return spec
    return " | ".join(
        call_string(call.path, _in_words(_strength(part) | call.arguments))
        for call, part in zip(calls, parts, strict=True)
    )


def _strength(part: Any) -> dict[str, Any]:
    """The parameters of a personality or a trait that are at their defaults, but those that are only on or off."""
    if part is None:
        return {}
    given = {field.name: getattr(part, field.name) for field in fields(part)}
    return {name: value for name, value in given.items() if not isinstance(value, bool | None)}


def _in_words(arguments: Mapping[str, Any]) -> dict[str, Any]:
    found = dict(arguments)
    if isinstance(kinds := found.get("kinds"), str):
        with contextlib.suppress(ValueError):
            found["kinds"] = "+".join(KIND_WORDS[kind] for kind in KINDS if kind in parse_kinds(kinds)) or kinds
    return found
