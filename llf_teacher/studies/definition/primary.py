"""Which comparisons of a study are primary: its pairs `compare`, or its tables `primary`."""

import contextlib
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

from llf_teacher.studies.definition.custom_specs import student_spec, teacher_spec
from teachers.spec import unknown

_LISTS = {
    "teacher": "teachers",
    "student": "students",
    "instruction_type": "instruction_types",
    "feedback_type": "feedback_types",
}


def check_primary(given: Any, study: Any, problems: list[str]) -> tuple[dict[str, str], ...]:
    """The tables in canonical form.

    Args:
        given: the tables in the study's file.
        study: the study, with its lists in canonical form.
        problems: the list to which problems are added.
    """
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        problems.append(f"primary must be a list of tables, got {given!r}")
        return ()
    return tuple(_table(each, study, problems) for each in given)


def _table(given: Any, study: Any, problems: list[str]) -> dict[str, str]:
    if not isinstance(given, Mapping) or not given:
        problems.append(f"primary must be tables with some of {', '.join(_LISTS)}, got {given!r}")
        return {}
    problems += [f"primary: {unknown('key', name, _LISTS)}" for name in given if name not in _LISTS]
    for name in _LISTS.keys() & given.keys():
        allowed = [each for each in getattr(study, _LISTS[name]) if name != "teacher" or each != study.baseline]
        pattern = canonical(name, given[name])
        if not isinstance(pattern, str) or not any(fnmatchcase(each, pattern) for each in allowed):
            problems.append(
                f"primary: {name} must be a pattern of one of {', '.join(allowed) or 'none'}, got {pattern!r}"
            )
    return {name: canonical(name, given[name]) for name in _LISTS if name in given}


def canonical(name: str, pattern: Any) -> Any:
    """A pattern of a `teacher` or a `student` in the study's form if it is a spec or an object; else unchanged."""
    check = {"teacher": teacher_spec, "student": student_spec}.get(name)
    if check is not None:
        with contextlib.suppress(ValueError, TypeError):
            return check(pattern)
    return pattern


def check_compare(given: Any, study: Any, problems: list[str]) -> tuple[tuple[str, str], ...]:
    """The pairs in canonical form; arguments as in `check_primary`."""
    form = f'must be a list of pairs of teachers, as in [["{study.teachers[0]}", "{study.teachers[-1]}"]]'
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        problems.append(f"compare {form}, got {given!r}")
        return ()
    found: dict[tuple[str, str], None] = {}
    for pair in given:
        if isinstance(pair, str | Mapping) or not isinstance(pair, Iterable) or len(both := tuple(pair)) != 2:
            problems.append(f"compare {form}, got {pair!r} among them")
            continue
        specs = [canonical("teacher", each) for each in both]
        if strange := [each for each in specs if each not in study.teachers]:
            problems += [f"compare: {unknown('teacher', each, study.teachers)}" for each in strange]
            continue
        one, other = specs
        if one == other:
            problems.append(f"compare: a teacher cannot be compared with itself, got {one!r} twice; name another")
        elif (other, one) in found:
            problems.append(f"compare: {one!r} and {other!r} are given in both orders; leave out one of them")
        found[one, other] = None
    return tuple(found)
