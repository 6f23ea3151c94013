"""Attempts at the same problem: how soon it is solved, and what a teacher's words add to being told to try again.

A turn is an attempt. acc@K is the share of episodes that are solved in the first K attempts; since an episode ends with
its success, that is the accuracy after K tries, too. The gain over `retry_only` is what is left of a teacher's effect
when that of another try is taken away (arXiv 2606.30774).
"""

from collections.abc import Mapping
from typing import NamedTuple

from llf_teacher.studies.analysis.outcomes import Endings, Numbers, Pair, paired
from llf_teacher.studies.analysis.statistics import Band, mean_band

CONTROL = "retry_only"
"""The teacher who only says that it was not it."""


class Attempts(NamedTuple):
    """One teacher with one student."""

    tries: tuple[int, ...]
    """Numbers of attempts, K."""
    solved: Band
    """acc@K, 0 to 1, for each K."""
    gain: Band | None
    """acc@K less that with the control on the same seeds; None for the control itself and where it has not played."""


def tries_of(max_turns: int) -> tuple[int, ...]:
    """The numbers of attempts that are looked at: powers of two, and as many as there can be."""
    return (*(2**i for i in range(max_turns.bit_length()) if 2**i < max_turns), max_turns)


def solved(cell: Endings, tries: tuple[int, ...]) -> Numbers:
    """Share of the environments that each seed has solved after so many attempts, shape (seeds, tries)."""
    shares: Numbers = (cell.first[:, :, None] <= tries).mean(axis=1)
    return shares


def attempts(cells: Mapping[Pair, Endings], max_turns: int, control: str = CONTROL) -> dict[Pair, Attempts]:
    """What came of each teacher with each student."""
    tries = tries_of(max_turns)
    found = {}
    for (teacher, student), cell in cells.items():
        gain = None
        if teacher != control and (control, student) in cells:
            own, other = paired(cell, cells[control, student])
            gain = mean_band(solved(own, tries) - solved(other, tries)) if len(own.seeds) else None
        found[teacher, student] = Attempts(tries, mean_band(solved(cell, tries)), gain)
    return found
