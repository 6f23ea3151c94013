"""Low-level steps of metaworld that cost less, with the same results to the last bit."""

import math
import sys
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from worlds.metaworld.arithmetic import cheaper, rebound
from worlds.metaworld.nearness import FINGERS, Nearness
from worlds.metaworld.state import FloatArray

_RESTS = 4
"""States in which the hand is held that are remembered; those of a new simulator come again in each episode."""


def cheapened(base: type) -> type:
    """A subclass of a metaworld environment's class whose steps are cheaper."""
    return type(base.__name__, (_Cheap, rebound(base, cheaper())), {})


def tried(env: Any, base: type, nearness: Nearness | None) -> Any:
    """The same environment, whose steps tell of where the hand is and whether the task is solved, and of nothing else.

    State and simulation are shared: what is asked of one happens to both.
    """
    cls: Any = type(base.__name__, (_Tried, rebound(base, cheaper() | _UNREWARDED)), {"_nearness": nearness})
    trial = cls.__new__(cls)
    trial.__dict__ = env.__dict__
    return trial


class _Cheap:
    """What makes a metaworld environment's step cheaper; comes before metaworld's class.

    Names are looked up once, arrays are not copied more often than need be, contacts are searched as plain numbers.
    What is added up is added up in the same order.
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
        # Plain numbers are read and written through views in a fraction of the time.
        self._reins: tuple[Any, ...] = (
            memoryview(data.mocap_pos[0]),
            memoryview(data.xpos[self.model.body_mocapid.tolist().index(0)]),
            data.mocap_quat[0],
            memoryview(data.ctrl),
            self.mocap_low.tolist(),
            self.mocap_high.tolist(),
        )
        self._pads = data.geom("leftpad_geom").id, data.geom("rightpad_geom").id
        self._known: dict[str, FloatArray] = {}
        self._sites: dict[str, FloatArray] = {}
        self._rests: dict[Any, FloatArray] = {}
        self._still = np.array([1.0, 0.0, 1.0, 0.0])
        self._unseen = np.full(39, np.nan)
        space = self.sawyer_observation_space
        self._bounds = space.low, space.high
        self._walls: tuple[list[float], list[float]] = space.low[:3].tolist(), space.high[:3].tolist()
        self.max_path_length = sys.maxsize

    @property
    def tcp_center(self) -> FloatArray:
        """The middle of the two fingers."""
        right, left = self._views[4:]
        middle: FloatArray = (right + left) / 2.0
        return middle

    def get_body_com(self, name: str) -> FloatArray:
        """A body's position, as MuJoCo keeps it."""
        known = self._known.get(name)
        if known is None:
            known = self._known[name] = self.data.body(name).xpos
        return known

    def _get_site_pos(self, name: str) -> FloatArray:
        """A copy of a site's position."""
        known = self._sites.get(name)
        if known is None:
            known = self._sites[name] = self.data.site(name).xpos
        return known.copy()

    def touching_object(self, geom: int) -> bool:
        """Whether both pads press on a geom."""
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
        """How far the gripper is open."""
        right, left = self._views[2:4]
        apart = right - left
        return min(max(math.sqrt(apart.dot(apart)) / 0.1, 0.0), 1.0)

    def _drive(self, command: Sequence[float], *, on: bool) -> None:
        """What one low-level step does in MuJoCo; `on` if it goes on after another one with the same grip.

        Such a step ends with what MuJoCo derives from where all is, and the next one begins with it. In between only
        the frame has moved to which the hand is held, and that collides with nothing: the rest is not derived again.
        """
        mujoco, model, data, substeps = self._views[0], self.model, self.data, self.frame_skip
        place, frame, rotation, fingers, low, high = self._reins
        x, y, z, grip = command
        scale = self.action_scale
        frame[0] = place[0] = min(max(place[0] + x * scale, low[0]), high[0])
        frame[1] = place[1] = min(max(place[1] + y * scale, low[1]), high[1])
        frame[2] = place[2] = min(max(place[2] + z * scale, low[2]), high[2])
        if on:
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

    def move(self, command: Sequence[float], *, on: bool = False) -> list[float]:
        """One low-level step, and the observation after it.

        Args:
            command: has to lie in [-1, 1].
            on: the last thing that was done here was another step, and the grip is the same.
        """
        self._drive(command, on=on)
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


class _Tried(_Cheap):
    """Steps of which nobody asks for the reward, which makes up much of a step, nor for what takes no part in success.

    Success follows from where hand and objects are and from what is touched; how objects are turned counts for rewards.
    """

    _nearness: Nearness | None
    _target_pos: FloatArray

    def _gripper_caging_reward(self, *_: Any, **__: Any) -> float:
        return 0.0

    def move(self, command: Sequence[float], *, on: bool = False) -> list[float]:
        """One low-level step, and where the hand is after it."""
        self._drive(command, on=on)
        x, y, z = self._views[1].tolist()
        low, high = self._walls
        return [min(max(x, low[0]), high[0]), min(max(y, low[1]), high[1]), min(max(z, low[2]), high[2])]

    def solves(self, seen: Sequence[float], command: Sequence[float]) -> bool:
        """Whether the task is solved now, after a command; `seen` is the observation, or no more than the hand."""
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
        observation = np.array(seen) if seen[3:] else self._look(seen)
        return bool(self.evaluate_state(observation, np.array(command))[1]["success"])

    def _look(self, hand: Sequence[float]) -> FloatArray:
        """The observation, as far as success follows from it; the rest is not a number."""
        observation = self._unseen.copy()
        observation[:3] = hand
        observation[3] = self._opening()
        positions = self._get_pos_objects()
        observation[4:7] = positions[:3]
        if len(positions) > 3:
            observation[11:14] = positions[3:]
        return observation


def _nothing(*_: Any, **__: Any) -> float:
    return 0.0


_UNREWARDED: dict[str, Any] = {
    "reward_utils": SimpleNamespace(tolerance=_nothing, hamacher_product=_nothing, rect_prism_tolerance=_nothing),
    "tolerance": _nothing,
}
"""What rewards are made of, in place of metaworld's own."""
