"""The world of Meta-World: a robot's hand moves to target poses, in turns of several low-level steps."""

import json
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces

from worlds.metaworld.original import Original
from worlds.metaworld.script import Aim, Script
from worlds.metaworld.simulator import PIXELS, Simulator, simulator_of
from worlds.metaworld.state import FloatArray, ImageArray, Pose, Truth
from worlds.metaworld.tasks import TASKS, TWO_OBJECTS
from worlds.world import World, illegal, is_number

CONTROLS = ("absolute", "relative", "teacher_event")
LONGEST, LONGEST_BY_EVENT = 15, 20
"""Greatest number of low-level steps in a turn, the latter with `control="teacher_event"`."""
SHORTEST = 3
"""Least number of low-level steps in a turn that does not solve the task."""
TRAVEL = 0.05
"""Distance of the hand from its start, in metres along an axis, beyond which a turn ends."""
ARRIVED = 1e-4
"""Distance of the hand to the target, in metres along each axis, below which it is reached."""
REACH = 2.0
"""Bound of the coordinates of a target, in metres."""
NEW_AIM, NEW_GRIP = 0.03, 0.3
"""Changes of advice that end a turn under `control="teacher_event"`: metres along an axis, and of the grip."""
_TABLE = ((-0.5, 0.4, 0.05, -1.0), (0.5, 1.0, 0.5, 1.0))  # bounds of sampled targets
_NEAR = ((-0.2, -0.2, -0.2, -1.0), (0.2, 0.2, 0.2, 1.0))


class MetaWorld(World[Truth, dict[str, Any], Pose]):
    """A robot's hand over a table, and one of metaworld's 50 tasks.

    Observation: Dict of `hand` (3, metres), `gripper` (1, 0 closed to 1 open), `object` (3) and `object_rotation` (4,
    metaworld's quaternion), `second_object` and `second_rotation` if there are two, and `goal` (3); with
    `visual=True` also `image`. Action: a target pose `[x, y, z, grip]`, metres and -1 (open) to 1 (close); with
    `control="relative"` x, y and z are relative to the hand. A turn drives the hand towards the target, with
    metaworld's low-level steps with the command `gain * (target - hand)`, clipped to [-1, 1]; see `_turn` for its end.
    Reward: metaworld's, of the turn's last low-level step, 0 to 10. Success: some low-level step of the episode has
    solved the task. Nothing terminates.

    Args:
        task: a name of `TASKS`.
        control: `absolute`, `relative`, or `teacher_event`: absolute, and a turn also ends when the target of
            metaworld's scripted policy changes.
        gain: the controller's gain; None: that of metaworld's scripted policy at the start of the turn.
        visual: add a camera image, uint8 (240, 240, 3), to the observation.
        video: put `video`, the images of a turn's low-level steps, into the info.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"]}  # noqa: RUF012 (as in `World`)
    reward_range = (0.0, 10.0)
    action_parts = ("x", "y", "z", "grip")
    action_fillers = ("move", "send", "hand", "aim", "at")
    answer_names = ("target", "pose")
    _truth: Truth

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
        _check("visual", visual, (False, True))
        _check("video", video, (False, True))
        if gain is not None and not (type(gain) in (int, float) and 0 < gain < math.inf):
            raise ValueError(f"gain must be None or a positive number, got {gain!r}")
        self.task = task
        self.script = Script(task)
        shapes = {"hand": 3, "gripper": 1, "object": 3, "object_rotation": 4}
        if task in TWO_OBJECTS:
            shapes |= {"second_object": 3, "second_rotation": 4}
        self._parts = tuple(shapes.items())
        boxes: dict[str, spaces.Space[Any]] = {
            name: spaces.Box(-np.inf, np.inf, (n,), np.float64) for name, n in (*self._parts, ("goal", 3))
        }
        if visual:
            boxes["image"] = spaces.Box(0, 255, (PIXELS, PIXELS, 3), np.uint8)
        self.observation_space = spaces.Dict(boxes)
        bounds = np.array([REACH, REACH, REACH, 1.0])
        self.action_space = spaces.Box(-bounds, bounds, dtype=np.float64)
        self.set_control(control)
        self._watch: Callable[[Sequence[float]], None] | None = None

    def set_control(self, control: str) -> None:
        """Change how actions are interpreted; see the argument `control`.

        Raises:
            ValueError: `control` is unknown.
        """
        _check("control", control, CONTROLS)
        self.options["control"] = control
        self.relative, self._event = control == "relative", control == "teacher_event"
        self.longest = LONGEST_BY_EVENT if self._event else LONGEST
        count = "counted from the hand" if self.relative else "in metres"
        self.action_syntax = (
            f"[x, y, z, grip] with x, y and z from {-REACH:g} to {REACH:g}, {count}, and grip from -1 to 1"
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Draw a variation of the task: positions of objects, and the goal."""
        super().reset(seed=seed, options=options)
        self._truth = simulator_of(self.task).reset(self.np_random)
        return self.observe(), {"success": False}

    @property
    def truth(self) -> Truth:
        """The state."""
        return self._truth

    def legal(self, action: Any) -> Pose:
        """The action as four Python floats."""
        numbers = action.tolist() if isinstance(action, np.ndarray) else action
        if isinstance(numbers, list | tuple) and len(numbers) == 4:
            bounds = (REACH, REACH, REACH, 1.0)
            if all(is_number(n) and -b <= n <= b for n, b in zip(numbers, bounds, strict=True)):
                x, y, z, grip = (float(n) + 0.0 for n in numbers)  # so that there is no negative zero
                return x, y, z, grip
        raise illegal(action, self.action_syntax)

    def target(self, truth: Truth, action: Pose) -> tuple[float, float, float]:
        """The target position of an action, in the coordinates of the table."""
        x, y, z, _ = action
        if self.relative:
            hand = truth.observation
            return hand[0] + x, hand[1] + y, hand[2] + z
        return x, y, z

    def advance(self, action: Pose) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Drive the hand towards the target until the turn ends."""
        simulator, truth = self.simulator(), self._truth
        video: list[ImageArray] = []
        watch = (lambda _: video.append(simulator.image())) if self.options["video"] else self._watch
        seen, command, solved = self._turn(simulator, simulator.env, truth, action, watch)
        reward, _ = simulator.env.evaluate_state(np.array(seen), np.array(command))
        self._truth = simulator.truth(tuple(seen), solved)
        info: dict[str, Any] = {"success": solved}
        if video:
            info["video"] = video
        return self.observe(), float(reward), False, False, info

    def foresee(self, truth: Truth, action: Pose) -> tuple[tuple[float, float, float], bool]:
        """The hand's position after an action in a state, and whether the task is solved; changes nothing."""
        simulator = simulator_of(self.task).load(truth)
        # With `teacher_event` the script needs the whole observation.
        env = simulator.env if self._event else simulator.probe
        seen, _, solved = self._turn(simulator, env, truth, action, None)
        x, y, z = seen[:3]
        return (x, y, z), solved

    def _turn(
        self,
        simulator: Simulator,
        env: Any,
        truth: Truth,
        action: Pose,
        watch: Callable[[Sequence[float]], None] | None,
    ) -> tuple[Sequence[float], Sequence[float], bool]:
        """Make the low-level steps of a turn; returns the last observation and command, and whether the task is solved.

        A turn ends with the step that solves the task. Otherwise it has at least 3 steps and ends when the hand has
        arrived or is more than 5 cm along an axis from its start, or after 15 steps. With `control="teacher_event"` it
        ends when the hand has arrived or the target of the scripted policy has changed, or after 20 steps.
        """
        aim = self.script.aim(truth.observation)
        gain = aim.gain if self.options["gain"] is None else self.options["gain"]
        target, move, solves = self.target(truth, action), env.move, simulator.probe.solves
        to_x, to_y, to_z = target
        start: Sequence[float] = truth.observation[:3]
        seen = start
        for count in range(1, self.longest + 1):
            x, y, z = seen[:3]
            command = (
                min(max(gain * (to_x - x), -1.0), 1.0),
                min(max(gain * (to_y - y), -1.0), 1.0),
                min(max(gain * (to_z - z), -1.0), 1.0),
                action[3],
            )
            seen = move(command, count > 1)
            if watch:
                watch(command)
            if not truth.solved and solves(seen, command):
                return seen, command, True
            if count >= SHORTEST and (_apart(target, seen) < ARRIVED or self._ends(aim, start, seen)):
                break
        return seen, command, truth.solved

    def _ends(self, aim: Aim, start: Sequence[float], seen: Sequence[float]) -> bool:
        """Whether a turn ends although the hand has not arrived."""
        if not self._event:
            return _apart(start, seen) > TRAVEL
        now = self.script.aim(tuple(seen))
        return _apart(now.target, aim.target) > NEW_AIM or abs(now.grip - aim.grip) > NEW_GRIP

    def observe(self) -> dict[str, Any]:
        """The poses of hand and objects, and the goal; with `visual=True` also the camera image."""
        numbers = np.array(self._truth.observation)
        observation, at = {}, 0
        for name, n in self._parts:
            observation[name] = numbers[at : at + n]
            at += n
        observation["goal"] = numbers[36:]
        if self.options["visual"]:
            observation["image"] = self.image()
        return observation

    def describe(self, observation: dict[str, Any]) -> str:
        """The observation as JSON, with numbers rounded to 0.001."""
        numbers = {
            name: [round(number, 3) + 0.0 for number in value.tolist()] if len(value) > 1 else round(value.item(), 3)
            for name, value in observation.items()
            if name != "image"
        }
        return json.dumps(numbers)

    def sample_action(self, rng: np.random.Generator) -> FloatArray:
        """A uniform pose over the table or, with `control="relative"`, near the hand."""
        return rng.uniform(*_NEAR) if self.relative else rng.uniform(*_TABLE)

    def render(self) -> str | ImageArray | None:
        """The observation as text, or with `render_mode="rgb_array"` the camera image, uint8 (240, 240, 3).

        Raises:
            RuntimeError: there is no off-screen OpenGL.
        """
        return self.image() if self.render_mode == "rgb_array" else super().render()

    def image(self) -> ImageArray:
        """The camera image, uint8 (240, 240, 3).

        Raises:
            RuntimeError: there is no off-screen OpenGL.
        """
        return self.simulator().image()

    def simulator(self) -> Simulator:
        """The task's simulator in this thread, with the current state loaded until another world uses it."""
        return simulator_of(self.task).load(self._truth)

    def original(self, actions: Sequence[Any], seed: int) -> Original:
        """Metaworld's environment, which makes the low-level steps of these turns."""
        world = type(self)(**self.options)
        world.reset(seed=seed)
        turns: list[list[FloatArray]] = []
        world._watch = lambda command: turns[-1].append(np.array(command))
        variation = world.truth.episode.variation
        for action in actions:
            turns.append([])
            world.step(action)
        return Original(self.task, variation, turns)

    def draw_options(self, rng: np.random.Generator) -> dict[str, Any]:
        """Any control, with the policy's gain or another."""
        gains = (None, 5.0, 10.0, 25.0)
        return self.options | {
            "control": CONTROLS[rng.integers(len(CONTROLS))],
            "gain": gains[rng.integers(len(gains))],
        }

    def _load(self, truth: Truth) -> None:
        self._truth = truth


def _apart(one: Sequence[float], other: Sequence[float]) -> float:
    """The largest distance along an axis."""
    return max(abs(one[0] - other[0]), abs(one[1] - other[1]), abs(one[2] - other[2]))


def _check(name: str, value: Any, allowed: Any) -> None:
    if type(value) is not type(next(iter(allowed))) or value not in allowed:
        raise ValueError(f"{name} must be one of {', '.join(map(str, allowed))}, got {value!r}")
