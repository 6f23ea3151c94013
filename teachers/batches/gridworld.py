"""The gridworld's oracle in arrays: all claims about a room follow from the room's compass."""

import numpy as np

from teachers.batches import Moments, OracleBatch, Said, subset
from teachers.oracles.gridworld import WARNED
from worlds.batches import Floats, Ints
from worlds.batches.gridworld import GridworldBatch, State
from worlds.gridworld import DIRECTIONS, SIDES

_CYCLE = 12  # after so many turns every list of at most four warnings begins again
_NEARER = np.array([[direction in sides.nearer for direction in DIRECTIONS] for sides in SIDES]).ravel()
_ADVISED = np.array([sides.nearer[0] if sides.nearer else 0 for sides in SIDES])
_WARNS = np.array([bool(warned) for warned in WARNED])
_WARNED = np.array([[warned[turn % len(warned)] if warned else 0 for turn in range(_CYCLE)] for warned in WARNED])


class GridworldOracleBatch(OracleBatch[State]):
    """Judges moves by the tables of the houses."""

    worlds: GridworldBatch

    def judge(self, moments: Moments[State]) -> Said:
        """Judge the move; advise the first direction that leads nearer; warn of the others in turn."""
        before, action, _, after, _, turn, over = moments
        compass = self.worlds.houses.compass
        acted = turn > 0
        judged = acted & ~before.found
        nearer = _NEARER.take(compass.take(before.place) * np.int64(len(DIRECTIONS)) + action)
        here = compass.take(after.place).astype(np.int64)
        searches = ~(after.found | over)
        kinds = subset(acted, judged & nearer, judged & ~nearer, searches, searches & _WARNS.take(here))
        return Said(kinds, _ADVISED.take(here), _WARNED.take(here * _CYCLE + turn % _CYCLE))

    def values(self, state: State) -> Floats:
        """Per direction, the negated number of moves left after it; all 0 once the treasure is found."""
        houses = self.worlds.houses
        behind = houses.doors.take(state.place, axis=0) + state.base[:, None]
        values = -houses.distance.take(behind).astype(np.float64)
        values[state.found] = 0.0
        return values

    def plan_length(self, state: State, n: int) -> Ints:
        """Moves to the treasure."""
        moves = np.minimum(self.worlds.houses.distance.take(state.place), n)
        moves[state.found] = 0
        return moves
