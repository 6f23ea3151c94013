"""metaworld's environments with faster low-level steps, whose results are the same to the last bit.

Each override states its gain: how much longer a turn takes without it, measured with a student's random
actions in tasks with and without a grasp. Together they save two to four fifths of the time of a taught turn.
"""

import math
import sys
import types
from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from worlds.metaworld.nearness import FINGERS, Nearness
from worlds.metaworld.rotation import Rotation
from worlds.metaworld.state import FloatArray

_RESTS = 4
"""Number of states that `_reset_hand` remembers; the first ones of a new simulator recur in each episode."""


def fast_env_class(base: type) -> type:
    """A subclass of a metaworld environment's class with faster steps."""
    return type(base.__name__, (_FastEnv, _rebound(base, {"Rotation": Rotation})), {})


def probe_env(env: Any, base: type, nearness: Nearness | None) -> Any:
    """An environment that shares state and simulation with `env`; its steps return only the hand and success.

    A step of either is a step of both.
    """
    cls: Any = type(base.__name__, (_ProbeEnv, _rebound(base, _UNREWARDED)), {"_nearness": nearness})
    probe = cls.__new__(cls)
    probe.__dict__ = env.__dict__
    return probe


def _rebound(base: type, names: Mapping[str, Any]) -> type:
    """A subclass of a metaworld environment's class, in whose methods these globals replace metaworld's.

    There the class's own name means this subclass.
    """
    bound = type(base.__name__, (base,), {})
    names = {**names, base.__name__: bound}
    methods: dict[str, Any] = {}
    for cls in reversed(base.__mro__):
        for name, value in vars(cls).items():
            methods.pop(name, None)
            function = value.__func__ if isinstance(value, staticmethod) else value
            if isinstance(function, types.FunctionType) and names.keys() & set(function.__code__.co_names):
                copy = types.FunctionType(
                    function.__code__, function.__globals__ | names, name, function.__defaults__, function.__closure__
                )
                copy.__kwdefaults__ = function.__kwdefaults__
                methods[name] = staticmethod(copy) if isinstance(value, staticmethod) else copy
    for name, method in methods.items():
        setattr(bound, name, method)
    return bound


class _FastEnv:
    """Overrides of a metaworld environment's class, before it in the order of bases. Sums keep their order."""

    # Attributes of metaworld's class.
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
        """Look up names in the model; call this once, after construction."""
        data = self.data
        self._views = (
            mujoco,
            data.body("hand").xpos,
            data.body("rightclaw").xpos,
            data.body("leftclaw").xpos,
            data.site("rightEndEffector").xpos,
            data.site("leftEndEffector").xpos,
        )
        self._bodies: dict[str, FloatArray] = {}
        self._controls: tuple[Any, ...] = (  # views for reading and writing single numbers
            memoryview(data.mocap_pos[0]),
            memoryview(data.xpos[self.model.body_mocapid.tolist().index(0)]),
            data.mocap_quat[0],
            memoryview(data.ctrl),
            self.mocap_low.tolist(),
            self.mocap_high.tolist(),
        )
        self._pads = data.geom("leftpad_geom").id, data.geom("rightpad_geom").id
        self._rests: dict[Any, FloatArray] = {}
        self._still = np.array([1.0, 0.0, 1.0, 0.0])
        self._unseen = np.full(39, np.nan)
        space = self.sawyer_observation_space
        self._bounds = space.low, space.high
        self._walls: tuple[list[float], list[float]] = space.low[:3].tolist(), space.high[:3].tolist()
        self.max_path_length = sys.maxsize

    @property
    def tcp_center(self) -> FloatArray:
        """The middle between the fingers; where success depends on it, a turn takes a twentieth longer without it."""
        right, left = self._views[4:]
        middle: FloatArray = (right + left) / 2.0
        return middle

    def get_body_com(self, name: str) -> FloatArray:
        """A view on the position of a body, which is looked up once."""
        known = self._bodies.get(name)
        if known is None:
            known = self._bodies[name] = self.data.body(name).xpos
        return known

    def touching_object(self, geom: int) -> bool:
        """Whether both pads press on a geom; without it a turn takes a tenth longer in tasks with a grasp."""
        contact = self.data.contact
        left = right = 0
        for i, pair in enumerate(zip(contact.geom1.tolist(), contact.geom2.tolist(), strict=True)):
            if geom in pair:
                one, other = self._pads
                force = self.data.efc_force[contact.efc_address[i]]
                if one in pair:
                    left += force
                if other in pair:
                    right += force
        return left > 0 and right > 0

    def _reset_hand(self, steps: int = 50) -> None:
        """As metaworld: hold the hand at its initial position for some steps.

        A cache keeps, for each initial state, the state before the last step; MuJoCo derives all else from it. Without
        this a turn takes a third longer, in episodes of 15 turns.
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
                del self._rests[next(iter(self._rests))]  # the least recently used
        else:
            mujoco.mj_setState(model, data, held, kind)
        self._rests[begun] = held
        metaworld._reset_hand(1)

    def _get_curr_obs_combined_no_goal(self) -> FloatArray:
        """As metaworld, with fewer copies of arrays; without it a turn takes a fifth longer."""
        hand = self._views[1]
        observation = np.zeros(18)
        observation[:3] = hand
        observation[3] = self._opening()
        positions, rotations = self._get_pos_objects(), self._get_quat_objects()
        observation[4:7], observation[7:11] = positions[:3], rotations[:4]
        if len(positions) > 3:
            observation[11:14], observation[14:18] = positions[3:], rotations[4:]
        return observation

    def _opening(self) -> float:
        """The opening of the gripper, 0 to 1."""
        right, left = self._views[2:4]
        apart = right - left
        return min(max(math.sqrt(apart.dot(apart)) / 0.1, 0.0), 1.0)

    def _simulate(self, command: Sequence[float], continues: bool) -> None:
        """Apply a command and run MuJoCo for one low-level step.

        A step ends with what MuJoCo derives from positions and velocities, and the next one would begin with it. In
        between only the frame has moved that holds the hand, and it collides with nothing: only constraints and forces
        are derived again. Otherwise a turn takes a tenth longer.
        """
        mujoco, model, data, substeps = self._views[0], self.model, self.data, self.frame_skip
        place, frame, rotation, fingers, low, high = self._controls
        x, y, z, grip = command
        scale = self.action_scale
        frame[0] = place[0] = min(max(place[0] + x * scale, low[0]), high[0])
        frame[1] = place[1] = min(max(place[1] + y * scale, low[1]), high[1])
        frame[2] = place[2] = min(max(place[2] + z * scale, low[2]), high[2])
        if continues:
            substeps -= 1
            mujoco.mj_makeConstraint(model, data)
            mujoco.mj_referenceConstraint(model, data)
            mujoco.mj_fwdConstraint(model, data)
            mujoco.mj_Euler(model, data)
        else:
            rotation[:] = self._still
            fingers[0], fingers[1] = grip, -grip
        mujoco.mj_step(model, data, substeps)
        mujoco.mj_forward(model, data)

    def move(self, command: Sequence[float], continues: bool = False) -> list[float]:
        """Make a low-level step.

        Args:
            command: in [-1, 1].
            continues: whether nothing has happened since another step with the same grip.

        Returns:
            The observation after it, 39 numbers.
        """
        self._simulate(command, continues)
        self.curr_path_length += 1
        low, high = self._bounds
        current = self._get_curr_obs_combined_no_goal()
        observation = np.empty(39)
        observation[:18], observation[18:36], observation[36:] = current, self._prev_obs, self._get_pos_goal()
        self._prev_obs = current
        seen: list[float] = np.minimum(np.maximum(observation, low), high).tolist()
        return seen

    def step(self, action: FloatArray) -> tuple[FloatArray, Any, bool, bool, dict[str, Any]]:
        """One low-level step, with metaworld's reward and info."""
        observation = np.array(self.move(action.tolist()))
        reward, info = self.evaluate_state(observation, action)
        return observation, reward, False, False, info


class _ProbeEnv(_FastEnv):
    """Steps without rewards, and only with the parts of observations that decide success.

    These are the positions of hand and objects, and contacts; the rotations of objects matter for rewards only.
    """

    _nearness: Nearness | None
    _target_pos: FloatArray

    def _gripper_caging_reward(self, *_: Any, **__: Any) -> float:
        return 0.0

    def move(self, command: Sequence[float], continues: bool = False) -> list[float]:
        """The same; returns the position of the hand after it."""
        self._simulate(command, continues)
        x, y, z = self._views[1].tolist()
        low, high = self._walls
        return [min(max(x, low[0]), high[0]), min(max(y, low[1]), high[1]), min(max(z, low[2]), high[2])]

    def solves(self, seen: Sequence[float], command: Sequence[float]) -> bool:
        """Whether the task is solved after a command; `seen` is the observation, or the hand's position only."""
        if self._nearness is not None:
            radius, axes, at = self._nearness
            if at == FINGERS:
                place, at = self.tcp_center.tolist(), 0
            else:
                place = self._get_pos_objects().tolist()
            target = self._target_pos.tolist()
            for axis in axes:
                if abs(place[at + axis] - target[axis]) > radius:
                    return False
        observation = np.array(seen) if seen[3:] else self._partial_observation(seen)
        return bool(self.evaluate_state(observation, np.array(command))[1]["success"])

    def _partial_observation(self, hand: Sequence[float]) -> FloatArray:
        """The parts of the observation that decide success; the rest is NaN."""
        observation = self._unseen.copy()
        observation[:3] = hand
        observation[3] = self._opening()
        positions = self._get_pos_objects()
        observation[4:7] = positions[:3]
        if len(positions) > 3:
            observation[11:14] = positions[3:]
        return observation


def _zero(*_: Any, **__: Any) -> float:
    return 0.0


_UNREWARDED: dict[str, Any] = {
    "reward_utils": SimpleNamespace(tolerance=_zero, hamacher_product=_zero, rect_prism_tolerance=_zero),
    "tolerance": _zero,
}
"""Replacements for the parts of rewards; without them a turn takes a fifth longer in tasks without a `Nearness`."""
