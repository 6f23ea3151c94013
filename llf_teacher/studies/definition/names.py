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
from teachers.spec import unknown

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
    parameters that differ between those of the same model; others are called by their spec.

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
    found = {spec: spec for spec in specs} | dict(given)
    for (head, behind), alike in models.items():
        names = [field.name for field in fields(next(iter(alike.values()))) if field.name not in _ALWAYS]
        apart = [name for name in names if len({repr(getattr(value, name)) for value in alike.values()}) > 1]
        shown = [name for name in apart if name not in _WHERE] or apart
        for spec, value in alike.items():
            found[spec] = ", ".join([head, *(f"{name}={getattr(value, name)!r}" for name in shown)]) + f"){behind}"
    taken = Counter(found.values())
    return {spec: name if taken[name] == 1 else spec for spec, name in found.items()}
