"""An environment of one's own, for tests of teaching it."""

from typing import ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces


class Walk(gymnasium.Env):
    """A random walk that can be made hard to copy, or to play again."""

    observation_space = spaces.Box(-100, 100, (1,))
    action_space = spaces.Discrete(2)
    metadata: ClassVar = {"render_modes": []}
    reward_range = (-1, 1)
    info: ClassVar = {}

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.at = float((options or {}).get("at", 0))
        return self._observe(), {}

    def step(self, action):
        self.at += action + self.np_random.random()
        return self._observe(), 0.5, self.at > 20, False, dict(self.info)

    def _observe(self):
        return np.array([self.at], np.float32)
