"""The episodes that a report shows turn by turn: the tables `transcripts` of a study."""

from collections.abc import Iterable, Mapping
from typing import Any

from llf_teacher.studies.definition.primary import canonical
from teachers.spec import unknown

PATTERNS = ("id", "teacher", "student")
_KEYS = (*PATTERNS, "seeds")


def check_transcripts(given: Any, problems: list[str]) -> tuple[dict[str, Any], ...]:
    """The tables in canonical form; adds to `problems`."""
    if isinstance(given, str | Mapping) or not isinstance(given, Iterable):
        problems.append(f"transcripts must be a list of tables, got {given!r}")
        return ()
    return tuple(_pattern(each, problems) for each in given)


def _pattern(given: Any, problems: list[str]) -> dict[str, Any]:
    if not isinstance(given, Mapping):
        problems.append(f"transcripts must be tables with some of {', '.join(_KEYS)}, got {given!r}")
        return {}
    problems += [f"transcripts: {unknown('key', name, _KEYS)}" for name in given if name not in _KEYS]
    for name in PATTERNS:
        if not isinstance(given.get(name, ""), str):
            problems.append(f"transcripts: {name} must be a pattern as in 'llf-*', got {given[name]!r}")
    seeds = given.get("seeds", [])
    if isinstance(seeds, str) or not isinstance(seeds, Iterable) or not all(type(seed) is int for seed in seeds):
        problems.append(f"transcripts: seeds must be a list of seeds, got {seeds!r}")
        return {}
    return {
        name: tuple(given[name]) if name == "seeds" else canonical(name, given[name]) for name in _KEYS if name in given
    }
