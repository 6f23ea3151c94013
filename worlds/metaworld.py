"""Meta-World: a robot arm with a gripper, one target pose a turn.

The simulator is metaworld's, on MuJoCo; its low-level steps are made cheaper here, with results that stay the same to
the last bit. A world holds its state as a value; the simulator that computes the next one is shared by all worlds of
the same task in a thread.
"""

import json
import math
import pickle
import sys
import threading
import types
from collections.abc import Callable, Sequence
from functools import lru_cache
from numbers import Real
from typing import Any, ClassVar, NamedTuple

import gymnasium
import numpy as np
from gymnasium import spaces

from worlds.world import World, illegal

Pose = tuple[float, float, float, float]

TASKS = (
    "assembly-v3",
    "basketball-v3",
    "bin-picking-v3",
    "box-close-v3",
    "button-press-topdown-v3",
    "button-press-topdown-wall-v3",
    "button-press-v3",
    "button-press-wall-v3",
    "coffee-button-v3",
    "coffee-pull-v3",
    "coffee-push-v3",
    "dial-turn-v3",
    "disassemble-v3",
    "door-close-v3",
    "door-lock-v3",
    "door-open-v3",
    "door-unlock-v3",
    "drawer-close-v3",
    "drawer-open-v3",
    "faucet-close-v3",
    "faucet-open-v3",
    "hammer-v3",
    "hand-insert-v3",
    "handle-press-side-v3",
    "handle-press-v3",
    "handle-pull-side-v3",
    "handle-pull-v3",
    "lever-pull-v3",
    "peg-insert-side-v3",
    "peg-unplug-side-v3",
    "pick-out-of-hole-v3",
    "pick-place-v3",
    "pick-place-wall-v3",
    "plate-slide-back-side-v3",
    "plate-slide-back-v3",
    "plate-slide-side-v3",
    "plate-slide-v3",
    "push-back-v3",
    "push-v3",
    "push-wall-v3",
    "reach-v3",
    "reach-wall-v3",
    "shelf-place-v3",
    "soccer-v3",
    "stick-pull-v3",
    "stick-push-v3",
    "sweep-into-v3",
    "sweep-v3",
    "window-close-v3",
    "window-open-v3",
)
"""metaworld's tasks."""
CONTROLS = ("absolute", "relative", "teacher_event")
LONGEST, LONGEST_BY_EVENT = 15, 20
"""Most low-level steps of a turn, the latter with `control="teacher_event"`."""
SHORTEST = 3
"""Fewest low-level steps of a turn that does not solve the task."""
TRAVEL = 0.05
"""So far from where it began, in metres along an axis, the hand ends a turn."""
ARRIVED = 1e-4
"""A target is reached when the hand is so close to it along each axis, in metres."""
REACH = 2.0
"""Bound of the coordinates of a target, in metres."""
NEW_AIM, NEW_GRIP = 0.03, 0.3
"""Changes of advice that end a turn under `control="teacher_event"`: metres along an axis, and of the grip."""
_SPARE = 4  # simulators that a thread keeps
_PASSING = ("curr_path_length", "_prev_obs", "_target_to_obj_init")  # what metaworld changes in a step, in Python
_SOLVER = ("model", "data", "mujoco_renderer", "_np_random", "_np_random_seed", "_views")
_TABLE = ((-0.5, 0.4, 0.05, -1.0), (0.5, 1.0, 0.5, 1.0))  # where students try out targets
_NEAR = ((-0.2, -0.2, -0.2, -1.0), (0.2, 0.2, 0.2, 1.0))
_TWO_OBJECTS = ("hammer-v3", "stick-pull-v3", "stick-push-v3")
_AXES = range(3)
_CAMERA, _PIXELS = "corner2", 240


class Episode(NamedTuple):
    """What stays the same for an episode; shared by reference between snapshots."""

    variation: tuple[float, ...]
    """metaworld's random vector: where things are."""
    bodies: bytes
    """`body_pos` of the MuJoCo model, which metaworld moves at reset."""
    sites: bytes
    """`site_pos` of the MuJoCo model."""
    attributes: tuple[tuple[str, Any], ...]
    """What metaworld's reset has written into its Python object; arrays as tuples."""


class Truth(NamedTuple):
    """The whole state."""

    observation: tuple[float, ...]
    """metaworld's 39 numbers: 18 of now, 18 of one low-level step before, the goal."""
    solved: bool
    """Whether the task has been solved in this episode."""
    physics: bytes
    """MuJoCo's integration state: positions, velocities, mocap, warm start, time and so on."""
    passing: tuple[Any, ...]
    """The attributes of metaworld's object that change in a step."""
    episode: Episode


class MetaWorld(World):
    """A robot's hand over a table, and one of metaworld's 50 tasks.

    Observation: Dict of `hand` (3, metres), `gripper` (1, 0 closed to 1 open), `object` (3) and `object_rotation` (4,
    as metaworld gives it), `second_object` and `second_rotation` where there are two, and `goal` (3); with
    `visual=True` `image`, too. Action: a target pose `[x, y, z, grip]`, metres and -1 (open) to 1 (close); with
    `control="relative"` x, y and z count from where the hand is. A turn drives the hand towards the target, by
    metaworld's low-level steps with the command `gain * (target - hand)`, clipped to [-1, 1]; see `_turn` for its end.
    Reward: metaworld's, of the turn's last low-level step, 0 to 10. Success: some low-level step of the episode has
    solved the task. Nothing terminates.

    Args:
        task: a name of `TASKS`.
        control: `absolute`, `relative`, or `teacher_event`: absolute, and a turn ends as well when metaworld's scripted
            policy begins to aim at something else.
        gain: the controller's gain; None: that of metaworld's scripted policy in the state in which the turn begins.
        visual: add a camera image, uint8 (240, 240, 3), to the observation.
        video: put `video`, the images of a turn's low-level steps, into the info.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["ansi", "rgb_array"]}
    reward_range = (0.0, 10.0)

    def __init__(
        self,
        task: str = "reach-v3",
        control: str = "absolute",
        *,
        gain: float | None = None,
        visual: bool = False,
        video: bool = False,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode=render_mode, task=task, control=control, gain=gain, visual=visual, video=video)
        _check("task", task, TASKS)
        _check("control", control, CONTROLS)
        _check("visual", visual, (False, True))
        _check("video", video, (False, True))
        if gain is not None and not (type(gain) in (int, float) and 0 < gain < math.inf):
            raise ValueError(f"gain must be None or a positive number, got {gain!r}")
        self.task, self.relative = task, control == "relative"
        self.script = Script(task)
        self._event = control == "teacher_event"
        self.longest = LONGEST_BY_EVENT if self._event else LONGEST
        shapes = {"hand": 3, "gripper": 1, "object": 3, "object_rotation": 4}
        if task in _TWO_OBJECTS:
            shapes |= {"second_object": 3, "second_rotation": 4}
        self._parts = tuple(shapes.items())
        boxes = {name: spaces.Box(-np.inf, np.inf, (n,), np.float64) for name, n in (*self._parts, ("goal", 3))}
        if visual:
            boxes["image"] = spaces.Box(0, 255, (_PIXELS, _PIXELS, 3), np.uint8)
        self.observation_space = spaces.Dict(boxes)
        bounds = np.array([REACH, REACH, REACH, 1.0])
        self.action_space = spaces.Box(-bounds, bounds, dtype=np.float64)
        count = "counted from the hand" if self.relative else "in metres"
        self.action_syntax = (
            f"[x, y, z, grip] with x, y and z from {-REACH:g} to {REACH:g}, {count}, and grip from -1 to 1"
        )
        self._truth: Truth | None = None
        self._watch: Callable[[np.ndarray], None] | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a variation of the task: where things are, and the goal."""
        super().reset(seed=seed)
        self._truth = _simulator(self.task).reset(self.np_random)
        return self._observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The state."""
        return self._truth

    def legal(self, action: Any) -> Pose:
        """The action as four Python floats."""
        numbers = action.tolist() if isinstance(action, np.ndarray) else action
        if isinstance(numbers, list | tuple) and len(numbers) == 4:
            bounds = (REACH, REACH, REACH, 1.0)
            if all(_is_number(n) and -b <= n <= b for n, b in zip(numbers, bounds, strict=True)):
                x, y, z, grip = (float(n) + 0.0 for n in numbers)  # so that there is no negative zero
                return x, y, z, grip
        raise illegal(action, self.action_syntax)

    def target(self, truth: Truth, action: Pose) -> tuple[float, float, float]:
        """Where an action sends the hand, in the coordinates of the table."""
        x, y, z, _ = action
        if self.relative:
            hand = truth.observation
            return hand[0] + x, hand[1] + y, hand[2] + z
        return x, y, z

    def advance(self, action: Pose) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Drive the hand towards the target until the turn ends."""
        simulator, truth = _simulator(self.task), self._truth
        simulator.load(truth)
        video: list[np.ndarray] = []
        watch = (lambda _: video.append(simulator.image())) if self.options["video"] else self._watch
        observation, reward, solved = self._turn(simulator, truth, action, watch)
        self._truth = simulator.truth(observation, truth.solved or solved)
        info: dict[str, Any] = {"success": self._truth.solved}
        if video:
            info["video"] = video
        return self._observe(), reward, False, False, info

    def _turn(
        self, simulator: "Simulator", truth: Truth, action: Pose, watch: Callable[[np.ndarray], None] | None
    ) -> tuple[tuple[float, ...], float, bool]:
        """The low-level steps of a turn: the last observation, its reward, and whether one of them solved the task.

        A turn ends with the step that solves the task. Else it has at least 3 steps, and ends when the hand has arrived
        or is more than 5 cm along an axis from where the turn began, or after 15 steps: a student is asked again before
        the hand has gone far. With `control="teacher_event"` it ends when the hand has arrived or the scripted policy
        aims at something else than at the turn's beginning, or after 20 steps.
        """
        aim = self.script.aim(truth.observation)
        gain = aim.gain if self.options["gain"] is None else self.options["gain"]
        target, step = self.target(truth, action), simulator.env.step
        start = hand = truth.observation[:3]
        command = np.empty(4)
        command[3] = action[3]
        for count in range(1, self.longest + 1):
            for i in _AXES:
                command[i] = min(max(gain * (target[i] - hand[i]), -1.0), 1.0)
            seen, reward, _, _, info = step(command)
            hand = seen[:3].tolist()
            if watch:
                watch(command)
            solved = bool(info["success"])
            if solved and not truth.solved:
                break
            if count >= SHORTEST and (_apart(target, hand) < ARRIVED or self._ends(aim, start, seen)):
                break
        return tuple(seen.tolist()), float(reward), solved

    def _ends(self, aim: "Aim", start: Sequence[float], seen: np.ndarray) -> bool:
        """Whether a turn ends before the hand has arrived."""
        if not self._event:
            return _apart(start, seen[:3].tolist()) > TRAVEL
        now = self.script.aim(tuple(seen.tolist()))
        return _apart(now.target, aim.target) > NEW_AIM or abs(now.grip - aim.grip) > NEW_GRIP

    def describe(self, observation: dict[str, Any]) -> str:
        """JSON, with numbers to a millimetre."""
        numbers = {
            name: [round(number, 3) + 0.0 for number in value.tolist()] if len(value) > 1 else round(value.item(), 3)
            for name, value in observation.items()
            if name != "image"
        }
        return json.dumps(numbers)

    def sample_action(self, rng: np.random.Generator) -> np.ndarray:
        """A uniform pose over the table, or one that is not far from the hand."""
        return rng.uniform(*_NEAR) if self.relative else rng.uniform(*_TABLE)

    def render(self) -> str | np.ndarray | None:  # type: ignore[override]
        """The observation as text, or with `render_mode="rgb_array"` the camera image, uint8 (240, 240, 3).

        Raises:
            RuntimeError: there is no off-screen OpenGL.
        """
        return self._image() if self.render_mode == "rgb_array" else super().render()

    def _image(self) -> np.ndarray:
        simulator = _simulator(self.task)
        simulator.load(self._truth)
        return simulator.image()

    def original(self, actions: Sequence[Any]) -> gymnasium.Env:
        """The environment of metaworld, which takes the low-level steps of these turns and nothing else."""
        world = type(self)(**self.options)
        world.reset(seed=0)
        turns: list[list[np.ndarray]] = []
        world._watch = lambda command: turns[-1].append(command.copy())
        variation = world.truth.episode.variation
        for action in actions:
            turns.append([])
            world.step(action)
        return _Original(self.task, variation, turns)

    def _load(self, truth: Truth) -> None:
        self._truth = truth

    def _observe(self) -> dict[str, Any]:
        numbers = np.array(self._truth.observation)
        observation, at = {}, 0
        for name, n in self._parts:
            observation[name] = numbers[at : at + n]
            at += n
        observation["goal"] = numbers[36:]
        if self.options["visual"]:
            observation["image"] = self._image()
        return observation


def _apart(one: Sequence[float], other: Sequence[float]) -> float:
    """The largest distance along an axis."""
    return max(abs(one[0] - other[0]), abs(one[1] - other[1]), abs(one[2] - other[2]))


def _check(name: str, value: Any, allowed: Any) -> None:
    if type(value) is not type(next(iter(allowed))) or value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(map(str, allowed))}, got {value!r}")


def _is_number(value: Any) -> bool:
    return type(value) is float or (isinstance(value, Real) and not isinstance(value, bool))


class Aim(NamedTuple):
    """What metaworld's scripted policy does in a state."""

    target: tuple[float, float, float]
    """Where it wants the hand to be."""
    gain: float
    """The factor from the hand's distance to its command."""
    grip: float
    """-1 opens the gripper, 1 closes it; anything between does so with less force."""


class Script:
    """metaworld's scripted policy of a task, asked for what it aims at instead of for a command."""

    def __init__(self, task: str) -> None:
        from metaworld.policies import ENV_POLICY_MAP

        self._task, self._policy = task, ENV_POLICY_MAP[task]()
        act = type(self._policy).get_action
        # A copy of the method that finds our `move` in place of metaworld's: nothing of metaworld is changed.
        self._act = types.FunctionType(act.__code__, act.__globals__ | {"move": self._move}, closure=act.__closure__)
        self._aimed: tuple[Any, float] = (None, 0.0)

    def __reduce__(self) -> tuple[Any, ...]:
        return Script, (self._task,)

    def _move(self, from_xyz: np.ndarray, to_xyz: np.ndarray, p: float) -> np.ndarray:
        self._aimed = to_xyz, p
        return p * (to_xyz - from_xyz)

    def command(self, observation: tuple[float, ...]) -> np.ndarray:
        """The policy's own command, float32 (4,): velocity and grip."""
        return self._act(self._policy, np.array(observation))  # some policies write into what they are given

    def aim(self, observation: tuple[float, ...]) -> Aim:
        """What it aims at."""
        grip = float(self.command(observation)[3])
        target, gain = self._aimed
        x, y, z = np.broadcast_to(target, (3,)).tolist()
        return Aim((x, y, z), float(gain), grip)


class Simulator:
    """The environment of metaworld of a task, with cheaper steps; worlds of one thread take turns to use it."""

    def __init__(self, task: str) -> None:
        import mujoco
        from metaworld.env_dict import ALL_V3_ENVIRONMENTS

        self._mujoco = mujoco
        base = ALL_V3_ENVIRONMENTS[task]
        cheap = type(base.__name__, (_Cheap, base), _rebound(base))
        env = self.env = cheap.__new__(cheap)  # constructed by metaworld's own code
        env.__dict__.update(base().__dict__)
        # As metaworld's MT1 sets its environments: tasks are given, and the goal can be seen.
        env._set_task_called, env._partially_observable = True, False
        env.__dict__.pop("sawyer_observation_space", None)
        env.prepare(mujoco)
        self._kind = mujoco.mjtState.mjSTATE_INTEGRATION
        self._size = mujoco.mj_stateSize(env.model, self._kind)
        self.objects = len(env._get_pos_objects()) // 3
        self._fresh = dict(env.__dict__)
        self._fresh_physics = self._physics(), env.model.body_pos.copy(), env.model.site_pos.copy()
        self._episode: Episode | None = None
        self._renderer: Any = None
        self._aliases = self._find_aliases()

    def reset(self, rng: np.random.Generator) -> Truth:
        """Begin an episode as metaworld begins it in a new environment, with a variation that it draws itself."""
        env = self.env
        self._renew()
        env._freeze_rand_vec, env.seeded_rand_vec, env._np_random = False, True, rng
        env.reset_model()
        variation = env._last_rand_vec
        self._renew()
        env._freeze_rand_vec, env._last_rand_vec = True, variation
        observation, _ = env.reset()
        fresh = self._fresh
        attributes = tuple(
            (name, tuple(value.tolist()) if isinstance(value, np.ndarray) else value)
            for name, value in sorted(env.__dict__.items())
            if value is not fresh.get(name, self) and name not in (*_SOLVER, *_PASSING, *self._aliases)
        )
        model = env.model
        self._episode = Episode(
            tuple(variation.tolist()), model.body_pos.tobytes(), model.site_pos.tobytes(), attributes
        )
        return self.truth(tuple(observation.tolist()), False)

    def truth(self, observation: tuple[float, ...], solved: bool) -> Truth:
        """A snapshot."""
        env = self.env.__dict__
        passing = (env[name] for name in _PASSING if name in env)
        kept = tuple(tuple(value.tolist()) if isinstance(value, np.ndarray) else value for value in passing)
        return Truth(observation, solved, self._physics().tobytes(), kept, self._episode)

    def load(self, truth: Truth) -> None:
        """Take over a snapshot. What MuJoCo derives from it is not computed: a step begins with that."""
        env, episode = self.env, truth.episode
        if episode is not self._episode:
            self._renew()
            env.model.body_pos[:] = np.frombuffer(episode.bodies).reshape(-1, 3)
            env.model.site_pos[:] = np.frombuffer(episode.sites).reshape(-1, 3)
            env.__dict__.update((name, _thawed(value)) for name, value in episode.attributes)
            env.__dict__.update(self._aliases)
            self._episode = episode
        names = (name for name in _PASSING if name in self._fresh)
        env.__dict__.update(zip(names, map(_thawed, truth.passing), strict=True))
        self._mujoco.mj_setState(env.model, env.data, np.frombuffer(truth.physics).copy(), self._kind)

    def image(self) -> np.ndarray:
        """What the camera sees now, uint8 (240, 240, 3)."""
        mujoco, env = self._mujoco, self.env
        physics = self._physics()
        try:
            if self._renderer is None:
                self._renderer = mujoco.Renderer(env.model, _PIXELS, _PIXELS)
            mujoco.mj_forward(env.model, env.data)  # a state that was loaded has no derived quantities yet
            self._renderer.update_scene(env.data, camera=_CAMERA)
            image = self._renderer.render()
        except Exception as error:
            raise RuntimeError(
                f"images need off-screen OpenGL, which failed with {error!r}; set the environment variable MUJOCO_GL "
                f"to egl (Debian: libegl1) or to osmesa (Debian: libosmesa6) before Python starts, or do without images"
            ) from error
        mujoco.mj_setState(env.model, env.data, physics, self._kind)
        return image[::-1, ::-1].copy()  # this camera hangs upside down

    def _physics(self) -> np.ndarray:
        physics = np.empty(self._size)
        self._mujoco.mj_getState(self.env.model, self.env.data, physics, self._kind)
        return physics

    def _renew(self) -> None:
        """Make the environment as it was after its construction."""
        env = self.env
        physics, bodies, sites = self._fresh_physics
        env.__dict__.clear()
        env.__dict__.update(self._fresh)
        env.model.body_pos[:], env.model.site_pos[:] = bodies, sites
        self._mujoco.mj_resetData(env.model, env.data)
        self._mujoco.mj_setState(env.model, env.data, physics, self._kind)
        self._mujoco.mj_forward(env.model, env.data)

    def _find_aliases(self) -> dict[str, np.ndarray]:
        """Attributes that metaworld's reset binds to MuJoCo's own memory, so that they follow the simulation."""
        self._aliases: dict[str, np.ndarray] = {}
        self.reset(np.random.default_rng(0))
        data = self.env.data
        arrays = [array for name in ("xpos", "xquat", "site_xpos", "geom_xpos") for array in (getattr(data, name),)]
        aliases = {
            name: value
            for name, value in self.env.__dict__.items()
            if isinstance(value, np.ndarray) and any(np.may_share_memory(value, array) for array in arrays)
        }
        self._episode = None
        return aliases


def _thawed(value: Any) -> Any:
    return np.array(value) if isinstance(value, tuple) else value


class _Original(gymnasium.Env):
    """The environment of metaworld as it comes; a step is the low-level steps of the next turn."""

    def __init__(self, task: str, variation: Sequence[float], turns: list[list[np.ndarray]]) -> None:
        from metaworld.env_dict import ALL_V3_ENVIRONMENTS
        from metaworld.types import Task

        cls = ALL_V3_ENVIRONMENTS[task]
        self.env = cls()
        self.env.max_path_length = sys.maxsize
        settings = {"env_cls": cls, "rand_vec": np.array(variation), "partially_observable": False}
        self.env.set_task(Task(task, pickle.dumps(settings)))
        self._turns = turns

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin the episode anew."""
        self._next = iter(self._turns)
        return self.env.reset()

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """The low-level steps of the next turn, which `action` was."""
        for command in next(self._next):
            result = self.env.step(command)
        return result


class _Cheap:
    """What makes a metaworld environment's step cheaper; comes before metaworld's class.

    Names are looked up once, arrays are not copied more often than need be, contacts are searched in arrays. What is
    added up is added up in the same order.
    """

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
        self._known: dict[str, np.ndarray] = {}
        self._still = np.array([1.0, 0.0, 1.0, 0.0])
        space = self.sawyer_observation_space
        self._bounds = space.low, space.high
        self.max_path_length = sys.maxsize

    @property
    def tcp_center(self) -> np.ndarray:
        """The middle of the two fingers."""
        return (self._views[4] + self._views[5]) / 2.0

    def get_body_com(self, name: str) -> np.ndarray:
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

    def _get_curr_obs_combined_no_goal(self) -> np.ndarray:
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

    def step(self, action: np.ndarray) -> tuple[np.ndarray, Any, bool, bool, dict[str, Any]]:
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

    def __init__(self, quaternion: np.ndarray) -> None:
        self._quaternion = quaternion

    @staticmethod
    def from_matrix(matrix: np.ndarray) -> Any:
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

    def as_quat(self) -> np.ndarray:
        """x, y, z, w."""
        return self._quaternion


def _is_rotation(rows: Any) -> bool:
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


_FLOATS = (float, np.float64)
_LONG_TAIL = math.sqrt(1 / 0.1 - 1)


class _Simulators(threading.local):
    """The simulators of a thread, those that were used last."""

    def __init__(self) -> None:
        self.of = lru_cache(maxsize=_SPARE)(Simulator)


_SIMULATORS = _Simulators()


def _simulator(task: str) -> "Simulator":
    return _SIMULATORS.of(task)
