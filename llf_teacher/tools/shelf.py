"""The shelf of personalities as tables for documents, made of the code."""

import dataclasses
import re
import sys
from pathlib import Path
from typing import Any

from pz_envs.family import all_families
from teachers.personality import PERSONALITIES

_PLACE = re.compile(r"(<!-- llf shelf: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def shelf() -> str:
    """A Markdown table of every personality: parameters, definition, source, honesty."""
    rows: list[tuple[str, ...]] = []
    for name in PERSONALITIES.names:
        cls: Any = PERSONALITIES[name]
        parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
        _, _, definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")
        honest = "yes" if cls().honest else "no"
        rows.append((f"`{name}({parameters})`" if parameters else f"`{name}`", definition, cls.source, honest))
    return _table(("personality", "what it does", "source", "honest"), rows)


def matrix() -> str:
    """A Markdown table of which family serves which personality, with what the personality needs of an oracle."""
    families = [family for family in all_families() if not family.version]  # those of this distribution
    rows = []
    for name in PERSONALITIES.names:
        served = ["yes" if family.serves(name) else "-" for family in families]
        rows.append((f"`{name}`", ", ".join(sorted(PERSONALITIES[name]().needs)), *served))
    return _table(("personality", "needs", *(family.name for family in families)), rows)


TABLES = {"shelf": shelf, "matrix": matrix}


def update(text: str) -> str:
    """A document with its tables made anew: what stands between `<!-- llf shelf: NAME -->` and `<!-- end -->`.

    Raises:
        ValueError: there is no such place, or no such table.
    """
    names = [match.group(2) for match in _PLACE.finditer(text)]
    if not names or set(names) - set(TABLES):
        raise ValueError(
            f"the document must have places for tables, `<!-- llf shelf: NAME -->` to `<!-- end -->` with NAME among "
            f"{', '.join(TABLES)}; got: {', '.join(names) or 'none'}"
        )
    return _PLACE.sub(lambda match: f"{match.group(1)}{TABLES[match.group(2)]()}{match.group(3)}", text)


def write(path: Path) -> None:
    """Update a file; errors as in `update`."""
    path.write_text(update(path.read_text(encoding="utf-8")), encoding="utf-8")


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)
