"""The bandits' oracle in arrays."""

import numpy as np

from teachers.batches import Moments, OracleBatch, Said, subset
from worlds.batches import Floats, Ints, chosen
from worlds.batches.bandits import State


class BanditOracleBatch(OracleBatch[State]):
    """Judges pulls by the arms' expected rewards."""

    def judge(self, moments: Moments[State]) -> Said:
        """Judge the arm; advise the first best one; warn of the others in turn."""
        _, action, _, after, _, turn, over = moments
        best, acted, goes_on = chosen(after.best, action), turn > 0, ~over
        poor = after.best.shape[1] - np.count_nonzero(after.best, axis=1)
        warned = chosen(after.order, turn % np.maximum(poor, 1))
        kinds = subset(acted, acted & best, acted & ~best, goes_on, goes_on & (poor > 0))
        return Said(kinds, chosen(after.order, poor), warned)

    def values(self, state: State) -> Floats:
        """Expected reward per arm."""
        return state.means

    def plan_length(self, state: State, n: int) -> Ints:
        """A best arm, again and again."""
        return np.full(len(state.means), n)
