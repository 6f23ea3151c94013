"""Meta-World as LLF-Bench has it: relative control, observations in JSON, the simulator and its policy."""

import json
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from llf_teacher.compat.env import LLFEnv

_MODES = ("absolute", "relative")
_UNUSED = ("unused", "extra_info", "_prev_obs")  # in the names of metaworld's parts of an observation


class Surface(LLFEnv):
    """Actions are metaworld's Box; observations are JSON of strings, with `visual=True` dicts of `text` and `image`.

    The strings are arrays as NumPy writes them, `"[0.1 0.2 0.3]"`, by metaworld's names.
    """

    def _actions(self) -> spaces.Space[Any]:
        return spaces.Box(-1.0, 1.0, (4,), np.float32)

    def _observations(self) -> spaces.Space[Any]:
        text = self._student.student_view.words_space["state"]
        image = self._world.observation_space.spaces.get("image")
        return text if image is None else spaces.Dict({"text": text, "image": image})

    def _observe(self, text: str) -> Any:
        parts = {
            name: np.array2string(value, precision=3, suppress_small=True) if np.ndim(value) else f"{value:.3f}"
            for name, value in self.mw_policy._parse_obs(self.current_observation).items()
            if not any(word in name for word in _UNUSED)
        }
        words = json.dumps(parts)
        return {"text": words, "image": self._world.image()} if self._world.options["visual"] else words

    def _instruct(self, instruction: str) -> str:
        task, mode = self._world.task.rpartition("-v")[0], self._world.options["control"]
        return (
            f"Your job is to control a Sawyer robot arm to solve a {task} task. You will get observations of the robot "
            f"state and the world state in the form of json strings. Your actions are 4-dim vectors, which set the "
            f"target pose of a step in {mode} coordinates. {instruction}"
        )

    def _informed(self, info: dict[str, Any]) -> dict[str, Any]:
        if "video" not in info:
            opening = self._student.session.moment.turn == 0 and self._world.options["video"]
            info = info | {"video": [self._world.image()] if opening else None}
        return super()._informed(info)

    def control_mode(self, mode: str) -> None:
        """Set whether x, y and z of actions are absolute positions (`absolute`) or offsets from the hand (`relative`).

        Raises:
            ValueError: another mode.
        """
        if mode not in _MODES:
            raise ValueError(f"control mode {mode!r} is unknown; allowed: {', '.join(_MODES)}")
        for world in (self._world, self._student.session.teacher.oracle.lab):
            world.set_control(mode)

    def render_video(self, value: bool = True) -> None:
        """Set whether the info has `video`, the images of a turn's low-level steps; otherwise it is None."""
        self._world.options["video"] = bool(value)

    @property
    def current_observation(self) -> npt.NDArray[np.float64]:
        """The observation of metaworld itself, 39 numbers."""
        return np.array(self._world.truth.observation)

    @property
    def mw_env(self) -> Any:
        """A metaworld environment in the current state, to be read only: changes to it have no effect."""
        env = self._world.simulator().env
        mujoco.mj_forward(env.model, env.data)  # computes the derived quantities of the loaded state
        return env

    @property
    def mw_policy(self) -> Any:
        """The scripted policy of the task, of metaworld."""
        return self._world.script.policy
