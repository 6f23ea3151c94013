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


def practice(family):
    """The type of instruction with feedback in it, `p`, if there is one; else the longest that there is."""
    types = family.oracle_class().instruction_types
    return "p" if "p" in types else types[-1]


def fewer(family, usual):
    """A number of turns, episodes or seeds; a slow simulator gets a thirtieth."""
    return max(usual // _SLOWER, 1) if family.slow else usual
