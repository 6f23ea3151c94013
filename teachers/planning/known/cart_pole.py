"""CartPole: a cart that is pushed left or right, so that the pole on it stays upright.

Two states are the same if their four numbers are, to the last bit.
"""

from collections.abc import Hashable
from typing import Any

import gymnasium
import numpy as np

from teachers.planning.known import Known

_Env = gymnasium.Env[Any, Any]
_LASTS = 40  # actions
_WEIGHTS = 1.0, 1.0, 20.0, 20.0  # of the squares of position, velocity, angle and angular velocity, after a while
_AHEAD = 0.5  # seconds


def _state(env: _Env) -> Hashable:
    return np.asarray(env.unwrapped.state).tobytes()  # type: ignore[attr-defined]  # of CartPole


def _danger(env: _Env) -> float:
    """How far cart and pole will be from the middle, if they go on as they do."""
    x, speed, angle, turning = map(float, env.unwrapped.state)  # type: ignore[attr-defined]  # of CartPole
    return _WEIGHTS[0] * (x + speed) ** 2 + _WEIGHTS[2] * (angle + _AHEAD * turning) ** 2


def _success(observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    """The pole is up at the end of the time limit."""
    return truncated and not terminated


def _describe(observation: Any) -> str:
    x, speed, angle, turning = map(float, observation)
    return (
        f"Cart position: {x:.3f}. Cart velocity: {speed:.3f}. Pole angle: {angle:.3f} rad. "
        f"Pole angular velocity: {turning:.3f}."
    )


KNOWN = Known(
    action_words={"left": 0, "right": 1},
    describe=_describe,
    state=_state,
    heuristic=_danger,
    lasts=_LASTS,
    success=_success,
    goal="keep the pole upright",
)
