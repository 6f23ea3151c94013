"""MountainCar: a car in a valley that has to swing up to the flag on the right hill.

Two states are the same if position and velocity are, to the last bit.
"""

from collections.abc import Hashable
from functools import lru_cache
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from teachers.planning.known import Known, constants

_Env = gymnasium.Env[Any, Any]
_Floats = npt.NDArray[np.float64]
_LOW, _HIGH = np.array([-1.2, -0.07]), np.array([0.6, 0.07])  # of position and velocity
_SHAPE = 91, 71
_FORCE, _GRAVITY = 0.001, 0.0025
_MOST = 300  # actions
_EAGER = 1.1  # the search follows the table rather than seek shorter ways


def _state(env: _Env) -> Hashable:
    position, velocity = env.unwrapped.state  # type: ignore[attr-defined]  # of MountainCar
    return float(position), float(velocity)


def _heuristic(env: _Env) -> float:
    """The number of actions by a table, between whose points it is interpolated."""
    bare: Any = env.unwrapped
    table = _table(float(bare.goal_position))
    (i, x), (j, y) = (
        divmod((float(value) - low) / (high - low) * (count - 1), 1)
        for value, low, high, count in zip(bare.state, _LOW.tolist(), _HIGH.tolist(), _SHAPE, strict=True)
    )
    i, j = min(int(i), _SHAPE[0] - 2), min(int(j), _SHAPE[1] - 2)
    rows = ((1 - y) * table[i + k][j] + y * table[i + k][j + 1] for k in (0, 1))
    return float(_EAGER * sum(share * row for share, row in zip((1 - x, x), rows, strict=True)))


@lru_cache(maxsize=4)
def _table(goal: float) -> list[list[float]]:
    """Per position and velocity the fewest actions to the flag, by value iteration on a grid."""
    axes = [np.linspace(low, high, count) for low, high, count in zip(_LOW, _HIGH, _SHAPE, strict=True)]
    position, velocity = np.meshgrid(*axes, indexing="ij")
    after = [_moved(position, velocity, push) for push in (-_FORCE, 0.0, _FORCE)]
    scale = (np.array(_SHAPE) - 1) / (_HIGH - _LOW)
    places = [(np.stack(each, axis=-1) - _LOW) * scale for each in after]
    left: _Floats = np.full(_SHAPE, float(_MOST))
    for _ in range(_MOST):
        options = [
            np.where(x >= goal, 0.0, map_coordinates(left, np.moveaxis(place, -1, 0), order=1, mode="nearest"))
            for (x, _), place in zip(after, places, strict=True)
        ]
        left = np.minimum(_MOST, 1 + np.min(options, axis=0))
    return left.tolist()  # type: ignore[no-any-return]  # of floats


def _moved(position: _Floats, velocity: _Floats, push: float) -> tuple[_Floats, _Floats]:
    """Position and velocity after one action, as Gymnasium's document gives them."""
    speed = np.clip(velocity + push - _GRAVITY * np.cos(3 * position), _LOW[1], _HIGH[1])
    there = np.clip(position + speed, _LOW[0], _HIGH[0])
    return there, np.where((there == _LOW[0]) & (speed < 0), 0.0, speed)


def _success(observation: Any, reward: float, terminated: bool, truncated: bool, info: dict[str, Any]) -> bool:
    """The flag ends an episode, and is paid no more than other steps."""
    return terminated


def _describe(observation: Any) -> str:
    position, velocity = map(float, observation)
    return f"Position of the car along the x-axis: {position:.3f}. Velocity of the car: {velocity:.4f}."


KNOWN = Known(
    action_words={"left": 0, "coast": 1, "right": 2},
    describe=_describe,
    state=_state,
    options=constants,
    heuristic=_heuristic,
    success=_success,
    goal="get the car to the flag on the right hill",
)
