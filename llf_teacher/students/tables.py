"""Numbers per state and action, for students that learn from evaluations; with tiles, nearby states share them."""

from collections.abc import Hashable
from typing import Any

import numpy as np
from gymnasium import spaces

Features = tuple[Hashable, ...]
"""The features of a state, each with weight 1: the state itself, or the tiles around it."""
_TILES = 8  # along each dimension
_DIMENSIONS = 4  # at most; with more, few tiles occur twice


class Table:
    """Numbers per feature and action; those of a state are the sums over its features.

    Args:
        actions: number of actions.
    """

    def __init__(self, actions: int) -> None:
        self._actions = actions
        self._rows: dict[Hashable, np.ndarray] = {}

    def __call__(self, state: Features) -> np.ndarray:
        """The numbers of a state, shape (actions,)."""
        total = np.zeros(self._actions)
        for feature in state:
            if (row := self._rows.get(feature)) is not None:
                total += row
        return total

    def add(self, state: Features, change: Any, action: int | slice = slice(None)) -> None:
        """Add to the numbers of a state, in equal parts to its features.

        Args:
            state: its features.
            change: a number, or one per action, shape (actions,).
            action: the action whose number changes; all by default.
        """
        for feature in state:
            row = self._rows.setdefault(feature, np.zeros(self._actions))
            row[action] += change / len(state)


class Tiling:
    """Tile coding of a box: several grids, each shifted by another part of a tile.

    Args:
        space: the states.
        count: number of grids.

    Raises:
        ValueError: the space is not a bounded box of at most four dimensions.
    """

    def __init__(self, space: spaces.Space[Any], count: int) -> None:
        if not isinstance(space, spaces.Box) or not space.is_bounded() or space.low.size > _DIMENSIONS:
            raise ValueError(
                f"tiles are for states in a bounded box of at most {_DIMENSIONS} dimensions, got {space}; give tiles=0"
            )
        self._low = space.low.astype(float).ravel()
        self._scale = _TILES / (space.high.astype(float).ravel() - self._low)
        odd = 2 * np.arange(len(self._low)) + 1  # the shifts differ by dimension, as Sutton & Barto advise
        self._shift = np.arange(count)[:, None] * odd / count % 1

    def __call__(self, state: Any) -> Features:
        """The tiles of a state, one per grid."""
        at = (np.asarray(state, float).ravel() - self._low) * self._scale
        tiles = np.floor(at + self._shift).astype(int)
        return tuple((number, *tile) for number, tile in enumerate(tiles.tolist()))
