"""Environments of the old Gym, recognised by their behaviour, without an import of Gym."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

__all__ = ["OldGym", "convert_space"]


class OldGym(gymnasium.Env[Any, Any]):
    """An environment with the interface that Gym had before 0.21, as a Gymnasium environment.

    The old interface: `reset()` gives an observation alone, `step` gives `(observation, reward, done, info)`,
    `seed(seed)` seeds, and `info["TimeLimit.truncated"]` marks an episode that a time limit ended. Intermediate
    versions (`reset` with an info, five values from `step`) work, too.

    Args:
        env: the old environment, later the attribute `old`.
        render_mode: mode for its `render(mode=...)`.

    Raises:
        ValueError: it lacks `reset` or `step`, or a space is of an unknown form.
    """

    def __init__(self, env: Any, render_mode: str | None = None) -> None:
        for method in ("reset", "step"):
            if not callable(getattr(env, method, None)):
                raise ValueError(f"{env!r} has no method {method}(); allowed: environments of the old Gym")
        self.old = env
        self.observation_space = convert_space(env.observation_space)
        self.action_space = convert_space(env.action_space)
        self.render_mode = render_mode
        old = getattr(env, "metadata", None) or {}
        self.metadata = {**old, "render_modes": list(old.get("render_modes", old.get("render.modes", ())))}
        if render_mode not in (None, *self.metadata["render_modes"]):
            allowed = ", ".join(self.metadata["render_modes"])
            raise ValueError(f"render_mode {render_mode!r} is unknown; allowed: None, {allowed}")
        if hasattr(env, "reward_range"):
            self.reward_range = tuple(env.reward_range)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; a seed is passed to the old `seed(seed)`. There are no options."""
        if options:
            raise ValueError(f"the old interface of {self.old!r} has no reset options, got {options!r}; allowed: None")
        super().reset(seed=seed)
        if seed is not None and hasattr(self.old, "seed"):
            self.old.seed(seed)
        result = self.old.reset()
        info: dict[str, Any] = {}
        if isinstance(result, tuple) and len(result) == 2 and isinstance(result[1], dict) and not self._sees(result):
            result, info = result
        return _convert_value(self.observation_space, result), dict(info)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step; `done` becomes `truncated` if the info has `TimeLimit.truncated`, else `terminated`."""
        observation, reward, *ends, info = self.old.step(action)
        if len(ends) == 2:
            terminated, truncated = map(bool, ends)
        else:
            done = bool(ends[0])
            truncated = done and bool(info.get("TimeLimit.truncated", False))
            terminated = done and not truncated
        return _convert_value(self.observation_space, observation), float(reward), terminated, truncated, dict(info)

    def render(self) -> Any:
        """The result of the old `render(mode=render_mode)`; None without a `render_mode`."""
        return None if self.render_mode is None else self.old.render(mode=self.render_mode)

    def close(self) -> None:
        """Close the old environment."""
        if hasattr(self.old, "close"):
            self.old.close()

    def _sees(self, value: Any) -> bool:
        return isinstance(self.observation_space, spaces.Tuple) and self.observation_space.contains(value)


def convert_space(space: Any) -> spaces.Space[Any]:
    """Convert an old space to Gymnasium's, by its attributes.

    Raises:
        ValueError: the space is of an unknown form.
    """
    if isinstance(space, spaces.Space):
        return space
    if hasattr(space, "spaces"):
        if hasattr(space.spaces, "items"):
            return spaces.Dict({key: convert_space(part) for key, part in space.spaces.items()})
        return spaces.Tuple([convert_space(part) for part in space.spaces])
    if hasattr(space, "nvec"):
        return spaces.MultiDiscrete(np.asarray(space.nvec))
    if hasattr(space, "low") and hasattr(space, "high"):
        dtype = np.dtype(getattr(space, "dtype", None) or np.float32)
        shape = tuple(getattr(space, "shape", None) or np.shape(space.low))
        low, high = (np.broadcast_to(np.asarray(bound, dtype), shape).copy() for bound in (space.low, space.high))
        return spaces.Box(low, high, shape, dtype.type)
    if hasattr(space, "n"):
        if getattr(space, "shape", None):  # both have an `n`, but only a bit vector has a shape
            return spaces.MultiBinary(space.n)
        return spaces.Discrete(int(space.n), start=int(getattr(space, "start", 0)))
    raise ValueError(
        f"cannot convert the space {space!r}; allowed: spaces with n, low and high, nvec, or spaces, "
        "as the old Discrete, MultiBinary, Box, MultiDiscrete, Tuple and Dict have"
    )


def _convert_value(space: spaces.Space[Any], value: Any) -> Any:
    """Convert an old observation to an element of the converted space, with its dtypes and Python numbers."""
    if isinstance(space, spaces.Dict):
        return {key: _convert_value(part, value[key]) for key, part in space.spaces.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(_convert_value(part, item) for part, item in zip(space.spaces, value, strict=True))
    if isinstance(space, spaces.Discrete):
        return int(value)
    if isinstance(space, spaces.Box | spaces.MultiBinary | spaces.MultiDiscrete):
        return np.array(value, space.dtype)
    return value
