"""Families and personalities as tables for documents, made of the code."""

import dataclasses
import inspect
import re
import sys
from pathlib import Path
from typing import Any

from llf_teacher.tools.markdown import table
from pz_envs.family import Family, all_families
from teachers.personality import PERSONALITIES

_PLACE = re.compile(r"(<!-- llf shelf: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def families() -> str:
    """A Markdown table of every family: environments, what is taught, turns, and by what it is judged."""
    rows: list[tuple[str, ...]] = []
    for family in _own_families():
        names = [f"`llf-{name}`" for name in family.showcase[:1]]
        more = len(family.environments) - len(names)
        doc = inspect.getdoc(family.oracle_class()) or ""
        oracle = " ".join(doc.partition("\n\n")[0].split())
        ids = f"{names[0]} and {more} more" if more else names[0]
        rows.append((family.name, ids, family.summary, str(family.max_turns), oracle))
    return table(("family", "environments", "task", "turns", "oracle"), rows)


def shelf() -> str:
    """A Markdown table of every personality: parameters, definition, source, honesty."""
    rows: list[tuple[str, ...]] = []
    for name in PERSONALITIES.names:
        cls: Any = PERSONALITIES[name]
        parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
        _, _, definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")
        honest = "yes" if cls().honest else "no"
        rows.append((f"`{name}({parameters})`" if parameters else f"`{name}`", definition, cls.source, honest))
    return table(("personality", "what it does", "source", "honest"), rows)


def matrix() -> str:
    """A Markdown table of which family serves which personality, with what the personality needs of an oracle."""
    families = _own_families()
    rows = []
    for name in PERSONALITIES.names:
        served = ["yes" if family.serves(name) else "-" for family in families]
        rows.append((f"`{name}`", ", ".join(sorted(PERSONALITIES[name]().needs)), *served))
    return table(("personality", "needs", *(family.name for family in families)), rows)


def _own_families() -> list[Family]:
    """Those of this distribution that are installed."""
    return [family for family in all_families() if not family.version and not family.missing()]


TABLES = {"families": families, "shelf": shelf, "matrix": matrix}


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


def documents(folder: Path) -> list[Path]:
    """The documents in a folder, `*.md` and `docs/*.md`, that have places for tables."""
    paths = sorted([*folder.glob("*.md"), *folder.glob("docs/*.md")])
    return [path for path in paths if _PLACE.search(path.read_text(encoding="utf-8"))]


def write(path: Path) -> None:
    """Update a file.

    Raises:
        ValueError: as in `update`, or the file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"cannot read {path}: {error}; give a Markdown file that has places for tables") from None
    path.write_text(update(text), encoding="utf-8")
