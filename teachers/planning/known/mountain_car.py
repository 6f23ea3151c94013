"""MountainCar: a car in a valley that has to swing up to the flag on the right hill; also with any force.

Two states are the same if position and velocity are, to the last bit. The search takes those for alike that lie in one
cell of a grid.
"""

import math
from collections.abc import Hashable
from typing import Any

import gymnasium

from teachers.planning.known import Known

_Env = gymnasium.Env[Any, Any]
_GRAVITY = 0.0025
_FORCE, _SPEED = 0.001, 0.025  # of the weaker engine; a speed that is usual on the way
_CELLS = 0.02, 0.002  # of position and velocity


def _state(env: _Env) -> Hashable:
    position, velocity = env.unwrapped.state  # type: ignore[attr-defined]  # of MountainCar
    return float(position), float(velocity)


def _alike(env: _Env) -> Hashable:
    position, velocity = env.unwrapped.state  # type: ignore[attr-defined]  # of MountainCar
    return round(float(position) / _CELLS[0]), round(float(velocity) / _CELLS[1])


def _heuristic(env: _Env) -> float:
    """The energy that the car lacks, over what the engine gives in one action at a usual speed."""
    bare: Any = env.unwrapped
    position, velocity = bare.state
    lacks = _height(bare.goal_position) - _height(position) - velocity**2 / 2
    return max(0.0, float(lacks)) / (_FORCE * _SPEED)


def _height(position: float) -> float:
    """Potential energy: the slope is `gravity * cos(3 * position)`."""
    return _GRAVITY / 3 * math.sin(3 * position)


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
    alike=_alike,
    heuristic=_heuristic,
    success=_success,
    goal="get the car to the flag on the right hill",
)
