"""Values as JSON text, and values in TOML files."""

import json
import re
import tomllib
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


def read_toml(path: Path) -> dict[str, Any]:
    """The table in a TOML file, in UTF-8 with or without a byte order mark.

    Raises:
        ValueError: the file cannot be read; the message has the file, the line and what to do.
    """
    data = b""
    try:
        data = path.read_bytes()
        return tomllib.loads(data.decode("utf-8-sig"))
    except OSError as error:
        raise ValueError(f"{path}: {error}") from None
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ValueError(f"{path}: line {line} has bytes that are not UTF-8; save the file as UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        twice = re.match("Cannot (overwrite|declare|mutate)|Duplicate", f"{error}")
        raise ValueError(f"{path}: {error}{'; give each key once, and each table' if twice else ''}") from None
    except ValueError as error:  # of a number of thousands of digits
        raise ValueError(f"{path}: {error}") from None
    except RecursionError:
        raise ValueError(f"{path}: too many lists or tables in each other; write lists and tables less deep") from None
