"""Which environments the default tests play, and how much of them: some families are large and slow."""

import pytest

from llf_teacher.registry import entries

_SLOWER = 30


def _params(values):
    return [
        pytest.param(value, id=entry.id, marks=() if entry.sampled else pytest.mark.full)
        for value, entry in zip(values, entries().values(), strict=True)
    ]


IDS = _params(entries())
"""Every id; those that the default tests leave out are marked `full`."""
ENTRIES = _params(entries().values())
"""Every environment, likewise."""


def fewer(family, usual):
    """A number of turns, episodes or seeds; a slow simulator gets a thirtieth."""
    return max(usual // _SLOWER, 1) if family.slow else usual
