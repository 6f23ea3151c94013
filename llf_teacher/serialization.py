"""Values as JSON text."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any


def to_json(value: Any) -> str:
    """JSON of a value, which may contain NumPy arrays and numbers."""
    return json.dumps(value, default=lambda item: item.tolist(), ensure_ascii=False)


def write_json_lines(path: Path, rows: Iterable[Any]) -> int:
    """Write rows as JSON, one per line; returns their number."""
    count = 0
    with path.open("w", encoding="utf-8") as file:
        for row in rows:
            file.write(to_json(row) + "\n")
            count += 1
    return count
