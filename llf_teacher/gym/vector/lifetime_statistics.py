"""Statistics of many lifetimes: `llf_teacher.gym.lifetime_statistics.LifetimeStatistics` in arrays."""

from typing import Any

import numpy as np
import numpy.typing as npt

from llf_teacher.gym.lifetime_statistics import EPISODE_RATE, HALF, TURN_RATE
from worlds.batches import Bools, Floats, Ints, without


class LifetimeStatisticsBatch:
    """The statistics of a lifetime in each row.

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
        """The numbers of `llf_teacher.gym.lifetime_statistics.FIELDS`, float32 of shape (rows, 9)."""
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
        """The arguments of `LifetimeStatistics.restore` for a row."""
        counts = zip(self.visits[row].tolist(), self.advised[row].tolist(), strict=True)
        return {
            "episode": int(self.episode[row]),
            "averages": (float(self.success[row]), float(self.optimal[row]), float(self.skill[row])),
            "counts": dict(zip(seen, counts, strict=True)),
        }


def _share(count: Ints) -> Floats:
    share: Floats = count / (count + HALF)
    return share


def columns(*parts: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Arrays side by side."""
    table = np.empty((len(parts[0]), len(parts)), np.float32)
    for column, part in enumerate(parts):
        table[:, column] = part
    return table
