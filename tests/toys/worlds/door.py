"""A door with a lock of two dials: it opens for one setting of both, drawn anew each episode."""

from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from worlds.world import World, illegal
from worlds.wrapped.actions import canonical

SETTINGS = tuple((left, right) for left in range(2) for right in range(3))


class Truth(NamedTuple):
    """The lock."""

    code: tuple[int, int]
    tried: tuple[int, int]
    """How the dials are set."""


class Door(World):
    """Set the dials until the door opens, which pays 1 and ends the episode.

    Observation: MultiBinary(2), a light per dial that is right. Action: MultiDiscrete([2, 3]), the dials.
    """

    reward_range = (0.0, 1.0)
    action_syntax = "a list of two integers, from [0, 0] to [1, 2]"

    def __init__(self, *, render_mode: str | None = None) -> None:
        super().__init__(render_mode=render_mode)
        self.observation_space = spaces.MultiBinary(2)
        self.action_space = spaces.MultiDiscrete([2, 3])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Draw a code, and set the dials to something else."""
        super().reset(seed=seed)
        code, tried = self.np_random.permutation(len(SETTINGS))[:2].tolist()
        self._load(Truth(SETTINGS[code], SETTINGS[tried]))
        return self._observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The lock."""
        return self._truth

    def legal(self, action: Any) -> tuple[int, int]:
        """The dials as a tuple."""
        try:
            return canonical(self.action_space, action)
        except (ValueError, TypeError, OverflowError):
            raise illegal(action, self.action_syntax) from None

    def advance(self, action: tuple[int, int]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Set the dials."""
        self._load(self._truth._replace(tried=action))
        opened = action == self._truth.code
        return self._observe(), float(opened), opened, False, {"success": opened}

    def describe(self, observation: Any) -> str:
        """The lights."""
        return f"Lights: {observation.tolist()}"

    def sample_action(self, rng: np.random.Generator) -> tuple[int, int]:
        """A uniform setting."""
        return SETTINGS[rng.integers(len(SETTINGS))]

    def _load(self, truth: Truth) -> None:
        self._truth = truth

    def _observe(self) -> Any:
        return np.array([a == b for a, b in zip(*self._truth, strict=True)], np.int8)
