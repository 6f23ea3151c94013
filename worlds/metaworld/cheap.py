"""Low-level steps of metaworld that cost less, with the same results to the last bit."""

import math
import sys
import types
from collections.abc import Callable, Sequence
from typing import Any, cast

import numpy as np

from worlds.metaworld.state import FloatArray

_FLOATS = (float, np.float64)
_RESTS = 4
"""States in which the hand is held that are remembered; those of a new simulator come again in each episode."""
_LONG_TAIL = math.sqrt(1 / 0.1 - 1)


def cheapened(base: type) -> type:
    """A subclass of a metaworld environment's class whose steps are cheaper."""
    return type(base.__name__, (_Cheap, base), _rebound(base))


class _Cheap:
    """What makes a metaworld environment's step cheaper; comes before metaworld's class.

    Names are looked up once, arrays are not copied more often than need be, contacts are searched in arrays. What is
    added up is added up in the same order.
    """

    # What metaworld's class has.
    model: Any
    data: Any
    sawyer_observation_space: Any
    action_scale: float
    frame_skip: int
    mocap_low: FloatArray
    mocap_high: FloatArray
    curr_path_length: int
    evaluate_state: Callable[[FloatArray, FloatArray], tuple[Any, dict[str, Any]]]
    _prev_obs: FloatArray
    _get_pos_goal: Callable[[], FloatArray]
    _get_pos_objects: Callable[[], FloatArray]
    _get_quat_objects: Callable[[], FloatArray]

    def prepare(self, mujoco: Any) -> None:
        """Look names up."""
        data = self.data
        self._views = (
            mujoco,
            data.body("hand").xpos,
            data.body("rightclaw").xpos,
            data.body("leftclaw").xpos,
            data.site("rightEndEffector").xpos,
            data.site("leftEndEffector").xpos,
        )
        self._pads = data.geom("leftpad_geom").id, data.geom("rightpad_geom").id
        self._known: dict[str, FloatArray] = {}
        self._rests: dict[Any, FloatArray] = {}
        self._still = np.array([1.0, 0.0, 1.0, 0.0])
        space = self.sawyer_observation_space
        self._bounds = space.low, space.high
        self.max_path_length = sys.maxsize

    @property
    def tcp_center(self) -> FloatArray:
        """The middle of the two fingers."""
        _, _, _, _, right, left = self._views
        middle: FloatArray = (right + left) / 2.0
        return middle

    def get_body_com(self, name: str) -> FloatArray:
        """A body's position, as MuJoCo keeps it."""
        known = self._known.get(name)
        if known is None:
            known = self._known[name] = self.data.body(name).xpos
        return known

    def touching_object(self, geom: int) -> bool:
        """Whether both pads press on a geom."""
        contact = self.data.contact
        first, second = contact.geom1, contact.geom2
        (found,) = np.nonzero((first == geom) | (second == geom))
        left = right = 0
        if len(found):
            one, other = self._pads
            force, addresses = self.data.efc_force, contact.efc_address
            for i in found.tolist():
                pair = first[i], second[i]
                if one in pair:
                    left += force[addresses[i]]
                if other in pair:
                    right += force[addresses[i]]
        return left > 0 and right > 0

    def _reset_hand(self, steps: int = 50) -> None:
        """As metaworld does, which holds the hand where it begins until it has come there.

        What came of that from the same state before is taken over, but for the last step: MuJoCo derives all the rest.
        """
        mujoco, model, data = self._views[0], self.model, self.data
        kind, metaworld = mujoco.mjtState.mjSTATE_INTEGRATION, cast("Any", super())
        physics = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, physics, kind)
        begun = physics.tobytes(), model.body_pos.tobytes(), steps
        held = self._rests.pop(begun, None)
        if held is None:
            metaworld._reset_hand(steps - 1)
            held = np.empty_like(physics)
            mujoco.mj_getState(model, data, held, kind)
            if len(self._rests) == _RESTS:
                del self._rests[next(iter(self._rests))]  # the one that was not used for longest
        else:
            mujoco.mj_setState(model, data, held, kind)
        self._rests[begun] = held
        metaworld._reset_hand(1)

    def _get_curr_obs_combined_no_goal(self) -> FloatArray:
        _, hand, right, left, _, _ = self._views
        observation = np.zeros(18)
        observation[:3] = hand
        apart = right - left
        observation[3] = min(max(math.sqrt(apart.dot(apart)) / 0.1, 0.0), 1.0)
        positions, rotations = self._get_pos_objects(), self._get_quat_objects()
        observation[4:7], observation[7:11] = positions[:3], rotations[:4]
        if len(positions) > 3:
            observation[11:14], observation[14:18] = positions[3:], rotations[4:]
        return observation

    def step(self, action: FloatArray) -> tuple[FloatArray, Any, bool, bool, dict[str, Any]]:
        """One low-level step; the action has to lie in [-1, 1]."""
        data, mujoco = self.data, self._views[0]
        moved = data.mocap_pos[0] + action[:3] * self.action_scale
        data.mocap_pos[0] = np.minimum(np.maximum(moved, self.mocap_low), self.mocap_high)
        data.mocap_quat[0] = self._still
        data.ctrl[0], data.ctrl[1] = action[3], -action[3]
        mujoco.mj_step(self.model, data, nstep=self.frame_skip)
        self.curr_path_length += 1
        mujoco.mj_forward(self.model, data)
        low, high = self._bounds
        current = self._get_curr_obs_combined_no_goal()
        observation = np.empty(39)
        observation[:18], observation[18:36], observation[36:] = current, self._prev_obs, self._get_pos_goal()
        self._prev_obs = current
        observation = np.minimum(np.maximum(observation, low), high)
        reward, info = self.evaluate_state(observation, action)
        return observation, reward, False, False, info


def _rebound(base: type) -> dict[str, Any]:
    """The methods of metaworld's classes that use scipy's rotations or metaworld's tolerances, with cheaper ones."""
    from metaworld.utils import reward_utils

    cheap = {"Rotation": _Rotation, "reward_utils": _Tolerances(reward_utils)}
    methods: dict[str, Any] = {}
    for cls in reversed(base.__mro__):
        for name, value in vars(cls).items():
            methods.pop(name, None)
            if isinstance(value, types.FunctionType) and cheap.keys() & set(value.__code__.co_names):
                bound = types.FunctionType(
                    value.__code__, value.__globals__ | cheap, name, value.__defaults__, value.__closure__
                )
                bound.__kwdefaults__ = value.__kwdefaults__
                methods[name] = bound
    return methods


class _Rotation:
    """`scipy.spatial.transform.Rotation`, as far as metaworld's observations need it: a matrix to a quaternion."""

    def __init__(self, quaternion: FloatArray) -> None:
        self._quaternion = quaternion

    @staticmethod
    def from_matrix(matrix: FloatArray) -> Any:
        """The arithmetic of scipy in scipy's order (Markley 2008); what is not quite a rotation is left to scipy."""
        rows = (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
        if not _is_rotation(rows):
            from scipy.spatial.transform import Rotation

            return Rotation.from_matrix(matrix)
        trace = a + e + i
        greatest = max(a, e, i, trace)
        if greatest == a:
            x, y, z, w = 1 - trace + 2 * a, d + b, g + c, h - f
        elif greatest == e:
            x, y, z, w = d + b, 1 - trace + 2 * e, h + f, c - g
        elif greatest == i:
            x, y, z, w = g + c, h + f, 1 - trace + 2 * i, d - b
        else:
            x, y, z, w = h - f, c - g, d - b, 1 + trace
        norm = math.sqrt(x * x + y * y + z * z + w * w)
        return _Rotation(np.array((x / norm, y / norm, z / norm, w / norm)))

    def as_quat(self) -> FloatArray:
        """x, y, z, w."""
        return self._quaternion


def _is_rotation(rows: Sequence[Sequence[float]]) -> bool:
    """Whether scipy takes a matrix for a rotation, with a margin to its own test."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (
        max(abs(a * d + b * e + c * f), abs(a * g + b * h + c * i), abs(d * g + e * h + f * i)) < 1e-13
        and max(abs(a * a + b * b + c * c - 1), abs(d * d + e * e + f * f - 1), abs(g * g + h * h + i * i - 1)) < 1e-6
        and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0.5
    )


class _Tolerances:
    """`metaworld.utils.reward_utils` with a cheaper `tolerance` for the common case."""

    def __init__(self, module: Any) -> None:
        self._module = module
        self.hamacher_product = module.hamacher_product

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)

    def tolerance(
        self, x: Any, bounds: Any = (0.0, 0.0), margin: Any = 0.0, sigmoid: str = "gaussian", **more: Any
    ) -> Any:
        """1 within the bounds, less outside; the same arithmetic on plain floats."""
        low, high = bounds
        if not (sigmoid == "long_tail" and margin > 0 and low <= high and type(x) in _FLOATS and not more):
            return self._module.tolerance(x, bounds, margin, sigmoid, **more)
        x = float(x)
        if low <= x <= high:
            return 1.0
        distance = float((low - x if x < low else x - high) / margin) * _LONG_TAIL
        return 1 / (distance**2 + 1)  # by pow, as NumPy does it with scalars
