"""Statistics of many lifetimes: `llf_teacher.gym.lifetime.Lifetime` in arrays."""

from typing import Any

import numpy as np
import numpy.typing as npt

from llf_teacher.gym.lifetime import EPISODE_RATE, HALF, TURN_RATE
from llf_teacher.students.scene import HeardBatch
from pz_envs.teacher_view import SUBSET_BITS
from teachers.atoms import HN, HP, KINDS
from teachers.batches import Said
from teachers.feedback import BIT
from worlds.batches import Bools, Floats, Ints, Rows, without


class Lifetimes:
    """A lifetime in each row.

    Args:
        rows: number of rows.
        states: number of states that a student can observe.
        episodes: number of episodes in a lifetime.
    """

    def __init__(self, rows: int, states: int, episodes: int) -> None:
        self.episodes = episodes
        self.episode = np.zeros(rows, np.int64)
        """Episodes that are over."""
        self.success, self.optimal, self.skill = np.zeros(rows), np.zeros(rows), np.zeros(rows)
        self.visits = np.zeros((rows, states), np.int32)
        """Earlier visits, int32 (rows, states)."""
        self.advised = np.zeros((rows, states), np.int32)
        """Visits in which an action was advised, int32 (rows, states)."""
        self.here = np.zeros(rows, np.int64)
        """The number of the student's current state, int64 (rows,)."""

    def begin(self, rows: Ints, places: Ints) -> None:
        """Begin lifetimes in these states."""
        for array in (self.episode, self.success, self.optimal, self.skill, self.visits, self.advised):
            array[rows] = 0
        self.here[rows] = places

    def forget(self, rows: Ints, lost: Bools, states: int) -> None:
        """Forget states that cannot recur, bool (len(rows), states); `states` is the number of states from now on."""
        self.visits = without(self.visits, rows, lost, states)
        self.advised = without(self.advised, rows, lost, states)

    def arrive(self, rows: Ints, places: Ints) -> None:
        """Count the current states."""
        self.visits[rows, self.here[rows]] += 1
        self.here[rows] = places

    def said(self, rows: Ints) -> None:
        """Count advised actions."""
        self.advised[rows, self.here[rows]] += 1

    def acted(self, rows: Ints, optimal: Bools) -> None:
        """Count actions."""
        self.optimal[rows] = optimal
        self.skill[rows] += TURN_RATE * (optimal - self.skill[rows])

    def end_episode(self, rows: Ints, success: Bools) -> None:
        """Count ends of episodes."""
        self.episode[rows] += 1
        self.success[rows] += EPISODE_RATE * (success - self.success[rows])
        self.optimal[rows] = 0

    def features(self, announced: Bools, mistake: Bools, way: Ints) -> npt.NDArray[np.float32]:
        """The numbers of `llf_teacher.gym.lifetime.FIELDS`, float32 of shape (rows, 9)."""
        all_rows = np.arange(len(self.here))
        visits, advised = self.visits[all_rows, self.here], self.advised[all_rows, self.here]
        return columns(
            self.episode / self.episodes,
            self.success,
            self.optimal,
            self.skill,
            _share(visits),
            _share(advised),
            announced,
            mistake,
            _share(way),
        )

    def restore_arguments(self, row: int, seen: list[Any]) -> dict[str, Any]:
        """The arguments of `Lifetime.restore` for a row."""
        counts = zip(self.visits[row].tolist(), self.advised[row].tolist(), strict=True)
        return {
            "episode": int(self.episode[row]),
            "averages": (float(self.success[row]), float(self.optimal[row]), float(self.skill[row])),
            "counts": dict(zip(seen, counts, strict=True)),
        }


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


def _share(count: Ints) -> Floats:
    share: Floats = count / (count + HALF)
    return share


def columns(*parts: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Arrays side by side."""
    table = np.empty((len(parts[0]), len(parts)), np.float32)
    for column, part in enumerate(parts):
        table[:, column] = part
    return table
