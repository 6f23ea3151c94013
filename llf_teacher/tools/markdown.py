"""Markdown: tables, escaped text, and generated parts of documents."""

import re
from collections.abc import Iterable, Mapping

__all__ = ["escape", "marked", "table", "update"]

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|])")


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table with a line break at its end; cells are Markdown, put into one line."""
    head = tuple(head)
    lines = [head, tuple("---" for _ in head), *(tuple(row) for row in rows)]
    return "".join(f"| {' | '.join(_cell(cell) for cell in line)} |\n" for line in lines)


def marked(text: str, command: str) -> list[str]:
    """The names between the markers of a command, `<!-- COMMAND: NAME -->` and `<!-- end -->`."""
    return [match.group(2) for match in _markers(command).finditer(text)]


def update(text: str, command: str, parts: Mapping[str, str]) -> str:
    """The text with new parts between the markers of a command; parts of other names stay."""
    return _markers(command).sub(lambda match: match[1] + parts.get(match[2], match[3]) + match[4], text)


def rows(text: str, command: str, name: str) -> list[list[str]]:
    """The cells of the table between the markers of this name, without its head; none if there is no table."""
    (found,) = (match[3] for match in _markers(command).finditer(text) if match[2] == name)
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in found.splitlines()[2:]]


def _markers(command: str) -> re.Pattern[str]:
    return re.compile(rf"(<!-- {command}: (\w+) -->\n)(.*?)(<!-- end -->)", re.DOTALL)


def escape(text: str) -> str:
    """The text in one line, with special characters escaped; code between backticks stays code."""
    parts = re.split(r"(`[^`]+`)", " ".join(text.split()))
    return "".join(part if part[:1] == "`" and len(part) > 1 else _SPECIAL.sub(r"\\\1", part) for part in parts)


def _cell(text: str) -> str:
    return re.sub(r"(?<!\\)\|", r"\\|", text.replace("\n", " "))
