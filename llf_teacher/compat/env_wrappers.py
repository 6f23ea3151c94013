"""LLF-Bench's wrappers; each has the attributes of the wrapped environment."""

import copy
import json
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
from gymnasium import spaces

from llf_teacher.compat.llf_env import Forwarding
from llf_teacher.gym import StudentEnv
from llf_teacher.students.agents import as_text
from worlds.actions import canonical, native, syntax
from worlds.wrapped.old_gym import OldGym

__all__ = [
    "EnvCompatibility",
    "FullInformationWrapper",
    "RandomActionOrderWrapper",
    "TerminalFreeWrapper",
    "TextWrapper",
]

EnvCompatibility = OldGym
"""The wrapped environment; LLF-Bench's name for `env`."""


class TextWrapper(Forwarding):
    """Parses text actions as JSON; environments of `make` and those with text actions parse them themselves.

    A text that is not an action gets feedback and a reward of 0; the environment does not step.
    """

    def step(self, action: str) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act in words."""
        space = self.action_space
        if isinstance(self.unwrapped, StudentEnv) or isinstance(space, spaces.Text):
            return self.env.step(str(action))
        try:
            read = native(space, canonical(space, json.loads(action)))
        except (ValueError, TypeError, OverflowError, RecursionError):
            feedback = f"{str(action)[:80]!r} is no action; the answer must be {syntax(space)}."
            observation = {"observation": None, "instruction": None, "feedback": feedback}
            return observation, 0.0, False, False, {"success": False}
        return self.env.step(read)


class TerminalFreeWrapper(Forwarding):
    """Episodes never end: only the info has the environment's `terminated` and `truncated`.

    After the end the environment does not step: the last observation is repeated, with reward 0.
    """

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode."""
        self._last: tuple[Any, dict[str, Any]] | None = None
        return self.env.reset(seed=seed, options=options)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act; nothing ends."""
        if self._last is not None:
            observation, info = self._last
            return observation, 0.0, False, False, dict(info)
        observation, reward, terminated, truncated, info = self.env.step(action)
        info = info | {"terminated": terminated, "truncated": truncated}
        if terminated or truncated:
            self._last = observation, info
        return observation, reward, False, False, info


class RandomActionOrderWrapper(Forwarding):
    """Shuffles the numbers of discrete actions at each reset; names of actions keep their meaning.

    Raises:
        ValueError: the actions are not discrete.
    """

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self.action_count = _count(self)
        self._order = list(range(self.action_count))
        self._rng: np.random.Generator | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode with a new order."""
        if seed is not None or self._rng is None:
            self._rng = np.random.default_rng(seed)
        self._order = self._rng.permutation(self.action_count).tolist()
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._renumber(info)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act by the shuffled number."""
        text = as_text(action).strip()
        known = text.isascii() and text.isdigit() and int(text) < self.action_count
        inner = self.internal_action(int(text)) if known else action
        observation, reward, terminated, truncated, info = self.env.step(inner)
        return observation, reward, terminated, truncated, self._renumber(info)

    def internal_action(self, action: int) -> int:
        """The environment's number of an action."""
        return self._order[action]

    def external_action(self, action: int) -> int:
        """The wrapper's number of an action of the environment."""
        return self._order.index(action)

    @property
    def expert_action(self) -> int | None:
        """The next action of an optimal policy, by the wrapper's number, or None."""
        expert = self.env.expert_action  # type: ignore[attr-defined]  # an AttributeError without one
        return None if expert is None else self.external_action(expert)

    def _renumber(self, info: dict[str, Any]) -> dict[str, Any]:
        expert = info.get("expert_action")
        return info if expert is None else info | {"expert_action": self.external_action(expert)}


class FullInformationWrapper(Forwarding):
    """Adds to the info of each step the results of all discrete actions.

    `full_information` is a list by action of dicts with `observation`, `reward`, `terminated`, `truncated` and `info`.

    Raises:
        ValueError: the actions are not discrete.
    """

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        self.action_count = _count(self)
        self._keys = ("observation", "reward", "terminated", "truncated", "info")

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Act; the info has the results of all actions."""
        outcomes = [
            dict(zip(self._keys, copy.deepcopy(self.env).step(other), strict=True))
            for other in range(self.action_count)
        ]
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, truncated, info | {"full_information": outcomes}


def _count(wrapper: gymnasium.Wrapper[Any, Any, Any, Any]) -> int:
    """The number of discrete actions."""
    space = wrapper.action_space
    if not isinstance(space, spaces.Discrete):
        raise ValueError(
            f"{type(wrapper).__name__} needs discrete actions, got {space}; use it with another environment"
        )
    return int(space.n)
