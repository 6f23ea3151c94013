"""Markdown: tables and escaped text."""

import re
from collections.abc import Iterable

__all__ = ["escape", "table"]

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|])")


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table with a line break at its end; cells are Markdown, put into one line."""
    head = tuple(head)
    lines = [head, tuple("---" for _ in head), *(tuple(row) for row in rows)]
    return "".join(f"| {' | '.join(_cell(cell) for cell in line)} |\n" for line in lines)


def escape(text: str) -> str:
    """The text in one line, with special characters escaped; code between backticks stays code."""
    parts = re.split(r"(`[^`]+`)", " ".join(text.split()))
    return "".join(part if part[:1] == "`" and len(part) > 1 else _SPECIAL.sub(r"\\\1", part) for part in parts)


def _cell(text: str) -> str:
    return re.sub(r"(?<!\\)\|", r"\\|", text.replace("\n", " "))
