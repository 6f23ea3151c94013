"""A door with a lock of two dials: it opens for one setting of both, drawn anew each episode."""

from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from worlds.world import World

SETTINGS = tuple((left, right) for left in range(2) for right in range(3))


Lights = NDArray[np.int8]


class Truth(NamedTuple):
    """The lock."""

    code: tuple[int, int]
    dials: tuple[int, int]


class Door(World[Truth, Lights, tuple[int, int]]):
    """Set the dials until the door opens, which pays 1 and ends the episode.

    Observation: MultiBinary(2), a light per dial that is right. Action: MultiDiscrete([2, 3]), the dials.
    """

    reward_range = (0.0, 1.0)

    def __init__(self, *, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode)
        self.observation_space = spaces.MultiBinary(2)
        self.action_space = spaces.MultiDiscrete([2, 3])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Lights, dict[str, Any]]:
        """Draw a code, and set the dials to something else."""
        super().reset(seed=seed, options=options)
        code, dials = self.np_random.permutation(len(SETTINGS))[:2].tolist()
        self._load(Truth(SETTINGS[code], SETTINGS[dials]))
        return self.observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The lock."""
        return self._truth

    def advance(self, action: tuple[int, int]) -> tuple[Lights, float, bool, bool, dict[str, Any]]:
        """Set the dials."""
        self._load(self._truth._replace(dials=action))
        opened = action == self._truth.code
        return self.observe(), float(opened), opened, False, {"success": opened}

    def observe(self) -> Lights:
        """The lights."""
        return np.array([dial == right for dial, right in zip(*self._truth, strict=True)], np.int8)

    def _load(self, truth: Truth) -> None:
        self._truth = truth
