"""Which comparisons of a study are primary: its tables `primary`."""

from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from typing import Any

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
        pattern = given[name]
        if not isinstance(pattern, str) or not any(fnmatchcase(each, pattern) for each in allowed):
            problems.append(
                f"primary: {name} must be a pattern of one of {', '.join(allowed) or 'none'}, got {pattern!r}"
            )
    return {name: given[name] for name in _LISTS if name in given}
