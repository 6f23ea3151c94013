"""Search for episodes in a store."""

import itertools
from typing import Any

from llf_teacher.studies.store import Store

PAGE = 100
"""Episodes on a page."""
_SOUGHT = ("id", "teacher", "student", "instruction_type", "feedback_type", "seed", "key")


def search(store: Store, words: str) -> tuple[list[dict[str, Any]], bool]:
    """The first `PAGE` episodes that contain all words, and whether there are more."""
    sought = words.lower().split()
    fits = (row for row in store.rows() if all(any(w in f"{row[name]}".lower() for name in _SOUGHT) for w in sought))
    rows = list(itertools.islice(fits, PAGE + 1))
    return rows[:PAGE], len(rows) > PAGE
