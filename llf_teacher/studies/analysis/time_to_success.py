"""Time to success: how many attempts a problem takes, and the gain by a teacher's words over mere repetition.

A turn is an attempt. acc@K is the share of episodes solved in the first K attempts; episodes end with success, so it is
also the accuracy after K attempts. The gain over `retry_only` is a teacher's effect beyond that of another attempt
(arXiv 2606.30774).
"""

from collections.abc import Mapping
from typing import NamedTuple

from llf_teacher.studies.analysis.outcomes import Endings, Numbers, Pair, paired
from llf_teacher.studies.analysis.statistics import Band, rate_band, rate_differences

CONTROL = "retry_only"
"""The teacher that only says that an action was not right."""


class Attempts(NamedTuple):
    """One teacher with one student."""

    tries: tuple[int, ...]
    """Numbers of attempts, K."""
    solved: Band
    """acc@K, 0 to 1, for each K."""
    gain: Band | None
    """acc@K minus acc@K with the control on the same seeds; None for the control itself and without its episodes."""


def tries_of(max_turns: int) -> tuple[int, ...]:
    """The numbers of attempts K: powers of two, and `max_turns`."""
    return (*(2**i for i in range(max_turns.bit_length()) if 2**i < max_turns), max_turns)


def solved(cell: Endings, tries: tuple[int, ...]) -> Numbers:
    """Share of the environments solved after each number of attempts, shape (seeds, tries)."""
    shares: Numbers = (cell.first[:, :, None] <= tries).mean(axis=1)
    return shares


def attempts(cells: Mapping[Pair, Endings], max_turns: int, control: str = CONTROL) -> dict[Pair, Attempts]:
    """acc@K of each teacher with each student, and its gain over the control."""
    tries = tries_of(max_turns)
    found = {}
    for (teacher, student), cell in cells.items():
        gain = None
        if teacher != control and (control, student) in cells:
            own, other = paired(cell, cells[control, student])
            gain = rate_differences(solved(own, tries), solved(other, tries)) if len(own.seeds) else None
        found[teacher, student] = Attempts(tries, rate_band(solved(cell, tries)), gain)
    return found
