"""How long a car has to drive into the spot, from a table over its pose: without plans and Reeds-Shepp paths.

For each pose, and each direction of the next piece, the table has the length of the shortest drive into the spot, in
metres, where a change of direction costs as much as `_CUSP`. It is made by value iteration on a grid, with the wheel
straight or turned fully; between the poses of the grid it is interpolated. A formula adds what the speed changes.

The car park of the table has no other cars and no side walls. So one table, mirrored and shifted, serves all spots at
the same distance from the other walls. It takes a quarter of a second, once, and 2 MB.
"""

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array, vstack

from teachers.oracles.parking.model import HALF, PUSH, STEPS, TOLERANCE
from worlds.parking import DT, WALL_Y, WIDTH, Truth

__all__ = ["MARGIN", "gain_of", "turns_left"]

MARGIN = 0.25
"""Change of `turns_left`, in turns, up to which an action is neither good nor bad."""

_Array = npt.NDArray[np.float64]
_TURN = STEPS * DT  # s
_PULL = PUSH / _TURN  # m/s2
_TOP = 5.0  # m/s
_CUSP = 4.0  # m
_SIDE = 24  # m to the side of the spot that the table covers; the rest of the way is added
_HEADINGS = 32
_FINEST = 2 * math.pi / _HEADINGS
_PIECE = 2.0  # m; a car touches no wall at the end of each piece
_SLIPS = (-math.atan(0.5), 0.0, math.atan(0.5))  # of a wheel at 45 degrees
_NEVER = 150.0  # m; more than any drive
_SETTLED = 0.05  # m by which the last iteration changes the table


class _Table(NamedTuple):
    """A grid of 1 m in space, of poses relative to the spot: its heading is 0, and lies along the second axis."""

    behind: float
    """How far the grid reaches behind the spot, in m."""
    rows: int
    """Number of places along the spot's heading."""
    lengths: tuple[list[float], list[float]]
    """Of drives that begin forwards, and of those that begin backwards, flat: across, along, heading."""


def turns_left(truth: Truth) -> float:
    """About how many turns parking takes, for a car that speeds up to 5 m/s and need not stop."""
    (x, y, heading, speed, _, _), (goal_x, goal_y, goal) = truth.car, truth.spot
    behind, rows, tables = _table(WALL_Y + abs(goal_y), WALL_Y - abs(goal_y))
    cosine, sine = math.cos(goal), math.sin(goal)
    across, along = cosine * (y - goal_y) - sine * (x - goal_x), cosine * (x - goal_x) + sine * (y - goal_y)
    turned = heading - goal if across > 0 else goal - heading
    beyond = max(abs(across) - _SIDE, 0.0)
    across, along = min(abs(across), _SIDE - 1e-9), min(max(along + behind, 0.0), rows - 1 - 1e-9)
    turned = turned / _FINEST % _HEADINGS
    column, row, ray = int(across), int(along), int(turned) % _HEADINGS
    across, along, turned = across - column, along - row, turned % 1
    corner, after = (column * rows + row) * _HEADINGS, (ray + 1) % _HEADINGS
    best = math.inf
    corners = (
        (corner, (1 - across) * (1 - along)),
        (corner + _HEADINGS, (1 - across) * along),
        (corner + rows * _HEADINGS, across * (1 - along)),
        (corner + (rows + 1) * _HEADINGS, across * along),
    )
    for lengths, pace in zip(tables, (speed, -speed), strict=True):
        far = beyond
        for start, share in corners:
            far += share * ((1 - turned) * lengths[start + ray] + turned * lengths[start + after])
        away = max(-pace, 0.0)  # the car rolls the other way, and has to stop and to come back
        slow = _TOP - min(max(pace, 0.0), _TOP)
        lost = slow**2 / (2 * _PULL)  # m by which it falls behind a car at full speed
        best = min(best, away / _PULL + (far + lost + away**2 / (2 * _PULL)) / _TOP)
    return best / _TURN


def gain_of(before: Truth, after: Truth) -> float:
    """By how many turns an action has shortened what is left; about 1 at best."""
    return turns_left(before) - turns_left(after)


@lru_cache(maxsize=4)
def _table(behind: float, ahead: float) -> _Table:
    """The table for a spot so far from the walls behind and ahead of it."""
    places = np.arange(-behind, ahead + 1e-9), np.arange(_HEADINGS) * _FINEST
    across, along, turned = (each.ravel() for each in np.meshgrid(np.arange(_SIDE + 1.0), *places, indexing="ij"))
    rows = len(places[0])
    off = abs(across) + 0.3 * abs(along) + 2 * (abs(np.cos(turned) - 1) + abs(np.sin(turned)))
    parked = off < TOLERANCE  # as `misfit` measures a spot whose heading is along an axis
    drives: list[tuple[csr_array, _Array]] = []  # one for each direction: where its pieces lead, and what they cost
    for way in (_PIECE, -_PIECE):
        ends, costs = [], []
        for slip in _SLIPS:
            bend = way * math.sin(slip) / HALF
            # The chord of an arc, half a percent too long where the wheel is turned.
            x = along + way * np.cos(turned + slip + bend / 2)
            y = across + way * np.sin(turned + slip + bend / 2)
            heading = turned + bend
            ends.append(_shares(y, x, heading, behind, rows))
            reach = HALF * abs(np.cos(heading)) + WIDTH / 2 * abs(np.sin(heading))
            inside = (x + reach < ahead) & (x - reach > -behind)
            costs.append(np.where(inside, _PIECE + np.maximum(abs(y) - _SIDE, 0), _NEVER))
        drives.append((vstack(ends, "csr"), np.array(costs)))
    both = np.where(parked, 0.0, _NEVER), np.where(parked, 0.0, _NEVER)
    change = math.inf
    while change > _SETTLED:
        turning = np.minimum(both[0], both[1] + _CUSP), np.minimum(both[1], both[0] + _CUSP)
        found = [
            np.minimum((lead @ later).reshape(costs.shape) + costs, _NEVER).min(0) * ~parked
            for (lead, costs), later in zip(drives, turning, strict=True)
        ]
        change = max(float(abs(new - old).max()) for new, old in zip(found, both, strict=True))
        both = found[0], found[1]
    return _Table(behind, rows, (both[0].tolist(), both[1].tolist()))


def _shares(across: _Array, along: _Array, turned: _Array, behind: float, rows: int) -> csr_array:
    """The matrix that interpolates the table in these poses: eight numbers each, as in `turns_left`."""
    turned = np.where(across < 0, -turned, turned) / _FINEST % _HEADINGS
    across, along = np.minimum(abs(across), _SIDE - 1e-9), np.clip(along + behind, 0.0, rows - 1 - 1e-9)
    column, row, ray = across.astype(int), along.astype(int), turned.astype(int) % _HEADINGS
    rests = across - column, along - row, turned % 1
    size = len(across)
    indices, shares = np.empty((size, 8), int), np.empty((size, 8))
    for corner, (i, j, k) in enumerate(product((0, 1), repeat=3)):
        indices[:, corner] = ((column + i) * rows + row + j) * _HEADINGS + (ray + k) % _HEADINGS
        shares[:, corner] = math.prod(rest if far else 1 - rest for rest, far in zip(rests, (i, j, k), strict=True))
    starts, shape = np.arange(0, 8 * size + 1, 8), (size, (_SIDE + 1) * rows * _HEADINGS)
    return csr_array((shares.ravel(), indices.ravel(), starts), shape=shape)
