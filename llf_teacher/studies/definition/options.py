"""Options of environments in a study, by patterns of ids: `[options."llf-metaworld-*"]` with `visual = true`."""

import json
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

from llf_teacher.registry import entry
from teachers.spec import unknown

_OURS = ("visual", "failure_reward")
"""Options of environments beside those of their worlds."""
_NOT = ("render_mode",)


def check_options(given: Any, ids: Sequence[str], problems: list[str]) -> dict[str, dict[str, Any]]:
    """The tables in canonical form; adds to `problems`."""
    if not isinstance(given, Mapping) or not all(isinstance(table, Mapping) for table in given.values()):
        problems.append(f"options must be a table of tables, got {given!r}")
        return {}
    for pattern, table in given.items():
        where = f"options.{json.dumps(pattern)}"
        if not any(fnmatchcase(id, pattern) for id in ids):
            problems.append(f"{where} matches none of the ids")
        try:
            json.dumps(dict(table), allow_nan=False)
        except (TypeError, ValueError):
            problems.append(f"{where} must hold texts, numbers, true or false, and lists of them, got {dict(table)!r}")
            continue
        for id in ids:
            if next((each for each in given if fnmatchcase(id, each)), None) == pattern:
                _check(where, id, table, problems)
    return {pattern: dict(table) for pattern, table in given.items()}


def _check(where: str, id: str, table: Mapping[str, Any], problems: list[str]) -> None:
    family, options = entry(id).family, entry(id).options
    allowed = sorted({*family.options(), *_OURS} - {*_NOT})
    if unknown_names := [name for name in table if name not in allowed]:
        problems.append(f"{where}: {id}: {unknown('option', unknown_names[0], allowed)}")
        return
    try:
        own = {name: value for name, value in table.items() if name not in _OURS or name in family.options()}
        world = family.make_world(**{**options, **own})
        low, high = world.reward_range
        visual, failure = table.get("visual", False), table.get("failure_reward", low)
        if not isinstance(visual, bool):
            raise ValueError(f"visual must be true or false, got {visual!r}")
        if visual and not (family.visual or family.drawn):
            raise ValueError("visual is not supported, since it has no images; allowed: false")
        if isinstance(failure, bool) or not isinstance(failure, int | float) or not low <= failure <= high:
            raise ValueError(f"failure_reward must be a number from {low} to {high}, got {failure!r}")
    except (ValueError, TypeError) as error:
        problems.append(f"{where}: {id}: {error}")


def options_of(tables: Mapping[str, Mapping[str, Any]], id: str) -> str:
    """The options of an id as JSON, from the first pattern that matches; empty without a match."""
    table = next((table for pattern, table in tables.items() if fnmatchcase(id, pattern)), {})
    return json.dumps(table, sort_keys=True) if table else ""


def read_options(text: str, id: str, words: bool) -> dict[str, Any]:
    """Options as keyword arguments of `make`.

    Args:
        text: JSON, from `options_of`.
        id: of the environment.
        words: whether the student reads texts; other students get no images if images come only beside texts.
    """
    options: dict[str, Any] = json.loads(text) if text else {}
    if not words and not entry(id).family.visual:
        options.pop("visual", None)
    return options
