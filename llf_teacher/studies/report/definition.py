"""A study as a file."""

import json
from collections.abc import Mapping
from typing import Any

from llf_teacher.studies.study import Study


def to_toml(study: Study) -> str:
    """The study as a file for `llf study run`."""
    values = study.as_dict()
    fewer = values.pop("fewer")
    tables = {name: table for name in ("looks", "transfer") if (table := values.pop(name))}
    values["transcripts"] = values["transcripts"] or None
    lines = _assignments(values)
    for name, table in tables.items():
        lines += ["", f"[{name}]", *_assignments(table)]
    for pattern, lists in fewer.items():
        lines += ["", f"[fewer.{json.dumps(pattern)}]", *_assignments(lists)]
    return "\n".join(lines) + "\n"


def _assignments(values: Mapping[str, Any]) -> list[str]:
    lines = []
    for name, value in values.items():
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
