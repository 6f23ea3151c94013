"""Answers: lists of titles in JSON, and their canonical form."""

import json
import re
from functools import lru_cache
from typing import Any

MAX_LENGTH = 10_000
"""Greatest number of characters of an answer."""
MAX_TITLES = 100
"""Greatest number of titles in an answer."""
MAX_TITLE = 200
"""Greatest number of characters of a title, a year included."""
_SPACE = " \t\n\r"  # of JSON
_quoted = json.encoder.encode_basestring  # the part of `json.dumps` that is needed, in a tenth of its time
_parsed = json.JSONDecoder().raw_decode  # the same of `json.loads`, in a third of its time
_FENCE = re.compile(r"```[a-z]*\n(.*)\n```", re.DOTALL)


def answer_of(titles: list[str] | tuple[str, ...]) -> str:
    """A list of titles in canonical form."""
    return f"[{', '.join(map(_quoted, titles))}]"


def titles_of(answer: str) -> tuple[str, ...]:
    """The titles of an answer in canonical form."""
    if not answer:
        return ()
    read = _read(answer)
    return read[1] if read and read[0] == answer else tuple(json.loads(answer))


def canonical(text: str) -> str | None:
    """The canonical form of an answer; None if the text is not an answer."""
    read = _read(text)
    return read and read[0]


@lru_cache(maxsize=1024)  # world and oracle read the same answers; without it a turn takes a fifth longer
def _read(text: str) -> tuple[str, tuple[str, ...]] | None:
    """The canonical form of an answer, and its titles."""
    text = text.strip()
    if text[:1] == "`" and (fenced := _FENCE.fullmatch(text)):
        text = fenced[1].strip(_SPACE)
    try:
        entries, end = _parsed(text)
    except (ValueError, RecursionError):
        return None
    if end < len(text) or not isinstance(entries, list) or len(entries) > MAX_TITLES:
        return None
    titles = [title for title in map(_title, entries) if title is not None]
    if len(titles) < len(entries):
        return None
    answer = answer_of(titles)
    return (answer, tuple(titles)) if len(answer) <= MAX_LENGTH else None


def _title(entry: Any) -> str | None:
    """The title in an entry of an answer, with the year if it has one; None if there is no title."""
    if isinstance(entry, str):
        title = " ".join(entry.split())
    elif isinstance(entry, dict) and isinstance(entry.get("title"), str):
        title, year = " ".join(entry["title"].split()), entry.get("year")
        if type(year) is int and 1000 <= year <= 9999 and f"({year})" not in title:
            title = f"{title} ({year})"
    else:
        return None
    return title if 0 < len(title) <= MAX_TITLE and title.isprintable() else None
