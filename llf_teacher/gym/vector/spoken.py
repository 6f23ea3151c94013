"""What teachers can say in the rows of a batch, and how much of it a subset of the kinds says."""

import numpy as np

from llf_teacher.students.scene import HeardBatch
from pz_envs.teacher_view import SUBSET_BITS
from teachers.atoms import HN, HP, KINDS
from teachers.batches import Said
from teachers.feedback import BIT
from worlds.batches import Ints, Rows


class Spoken:
    """The available claims in the rows, and the claims that a subset of kinds says.

    Args:
        said: the claims of the teachers.
    """

    def __init__(self, said: Said) -> None:
        self.kinds, self.advised, self.warned = said.kinds, said.advised, said.warned
        self._numbers: Ints | None = None
        self._naming = np.full(len(said.kinds), -1)
        """Kinds whose claims name an action."""
        if said.verdicts is not None:
            self._numbers = np.ones((len(said.kinds), len(KINDS)), np.int64)
            self._numbers[:, 1:3] = said.verdicts
        if said.judges is not None:
            self._naming -= ~said.judges @ np.array([BIT[HP], BIT[HN]])

    def say(self, subset: Ints, rows: Rows, left: Ints | None) -> tuple[Ints, Ints]:
        """Say the first claims of a subset, in speaking order, in some rows.

        Args:
            subset: a subset's number per row.
            rows: the rows.
            left: number of claims that may be said; None: all.

        Returns:
            The kinds with a said claim, as a subset's number, and the number of claims.
        """
        said = subset.astype(np.uint8) & self.kinds[rows]
        if self._numbers is None:
            said = said if left is None else WITHIN[said, np.minimum(left, len(KINDS))]
            return said, _COUNT[said]
        numbers = SUBSET_BITS[said] * self._numbers[rows]
        if left is not None:
            numbers = np.clip(left[:, None] - (numbers.cumsum(1) - numbers), 0, numbers)
        return (numbers > 0) @ _BITS, numbers.sum(1)

    def heard(self, rows: Ints, said: Ints) -> HeardBatch:
        """The kinds that students use when these kinds are said: hp and hn only if they name the action."""
        return HeardBatch(said.astype(np.int64) & self._naming[rows], self.advised[rows], self.warned[rows])


_BITS = np.array([BIT[kind] for kind in KINDS], np.uint8)
_COUNT = SUBSET_BITS.sum(1)
_FIRST = (SUBSET_BITS.cumsum(1)[:, None] <= np.arange(len(KINDS) + 1)[:, None]) & (SUBSET_BITS[:, None] > 0)
WITHIN = (_FIRST * _BITS).sum(2).astype(np.uint8)
"""For each subset and number of affordable atoms, the subset that is said, in speaking order; uint8 (32, 6)."""
