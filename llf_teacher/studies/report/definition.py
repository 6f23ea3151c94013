"""A study as a file."""

import json
import re
from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.definition.study import Study

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def to_toml(study: Study) -> str:
    """The study as a file for `llf study run`."""
    values = study.as_dict()
    patterns = {name: values.pop(name) for name in ("fewer", "options")}
    tables = {name: table for name in ("looks", "transfer", "names") if (table := values.pop(name))}
    values["transcripts"] = values["transcripts"] or None
    lines = _assignments(values)
    for name, table in tables.items():
        lines += ["", f"[{name}]", *_assignments(table)]
    for name, tables_ in patterns.items():
        for pattern, lists in tables_.items():
            lines += ["", f"[{name}.{json.dumps(pattern)}]", *_assignments(lists)]
    return "\n".join(lines) + "\n"


def _assignments(values: Mapping[str, Any]) -> list[str]:
    lines = []
    for key, value in values.items():
        name = key if _BARE.fullmatch(key) else json.dumps(key, ensure_ascii=False)
        if name == "seeds" and value == list(range(len(value))):
            lines.append(f"{name} = {len(value)}")
        elif isinstance(value, list) and len(value) > 1:
            items = "".join(f"    {_value(item)},\n" for item in value)
            lines.append(f"{name} = [\n{items}]")
        elif value is not None:
            lines.append(f"{name} = {_value(value)}")
    return lines


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{name} = {_value(each)}" for name, each in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)
