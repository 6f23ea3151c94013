"""CartPole: a cart that is pushed left or right, so that the pole on it stays upright.

Two states are the same if their four numbers are, to the last bit.
"""

from collections.abc import Hashable
from functools import lru_cache
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_discrete_are

from teachers.planning.known import Known, constants

_Env = gymnasium.Env[Any, Any]
_LASTS = 40  # actions
_PUSHES = 0.1  # what force costs, where a fall at either bound costs 1


def _state(env: _Env) -> Hashable:
    return tuple(map(float, env.unwrapped.state))  # type: ignore[attr-defined]  # of CartPole


def _danger(env: _Env) -> float:
    """What it costs to bring cart and pole to rest in the middle, if any force could be used and angles were small."""
    bare: Any = env.unwrapped
    cost = _cost(
        *map(float, (bare.gravity, bare.masspole, bare.total_mass, bare.length, bare.tau, bare.force_mag)),
        float(bare.x_threshold),
        float(bare.theta_threshold_radians),
    )
    state = np.asarray(bare.state)
    return float(state @ cost @ state)


@lru_cache(maxsize=4)
def _cost(
    gravity: float, pole: float, mass: float, length: float, tau: float, force: float, middle: float, upright: float
) -> npt.NDArray[np.float64]:
    """The costs of a linear-quadratic regulator, shape (4, 4), of Gymnasium's equations around the upright pole."""
    inertia = length * (4 / 3 - pole / mass)
    lean = gravity / inertia  # angular acceleration by the angle
    turn = -1 / (mass * inertia)  # and by the force
    arm = pole * length / mass
    moves = np.array([[0, 1, 0, 0], [0, 0, -arm * lean, 0], [0, 0, 0, 1], [0, 0, lean, 0]])
    pushed = np.array([[0], [1 / mass - arm * turn], [0], [turn]])
    far = np.diag([1 / middle**2, 0, 1 / upright**2, 0])
    found: npt.NDArray[np.float64] = solve_discrete_are(
        np.eye(4) + tau * moves, tau * pushed, far, np.array([[_PUSHES / force**2]])
    )
    return found


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
    options=constants,
    heuristic=_danger,
    lasts=_LASTS,
    success=_success,
    goal="keep the pole upright",
)
