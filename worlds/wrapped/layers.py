"""The wrappers around an environment, the time limits among them, and quick copies of the whole."""

import copy
from collections.abc import Iterator, Mapping
from typing import Any

import gymnasium
from gymnasium import spaces, wrappers
from gymnasium.envs.registration import EnvSpec

__all__ = ["copied", "is_plain", "is_table", "layers", "time_limits"]

_Env = gymnasium.Env[Any, Any]
_TIMERS = (  # wrappers whose state decides nothing but time
    *(wrappers.TimeLimit, wrappers.OrderEnforcing, wrappers.PassiveEnvChecker),
    *(wrappers.RecordEpisodeStatistics, gymnasium.ObservationWrapper),
)


def layers(env: _Env) -> Iterator[Any]:
    """The wrappers of an environment, and the environment itself."""
    while isinstance(env, gymnasium.Wrapper):
        yield env
        env = env.env
    yield env


def time_limits(env: _Env) -> tuple[int, ...]:
    """The limits of an episode's steps: of each `TimeLimit` around the environment, and of an attribute `max_steps`."""
    limits = [each._max_episode_steps for each in layers(env) if isinstance(each, wrappers.TimeLimit)]
    own = getattr(env.unwrapped, "max_steps", None)
    return (*limits, own) if type(own) is int and own > 0 else tuple(limits)


def is_table(name: str, part: Any) -> bool:
    """Whether an attribute is a table of transitions, as in Gymnasium's toy texts: large and constant."""
    return name == "P" and isinstance(part, Mapping)


def is_plain(layer: Any) -> bool:
    """Whether it is a bare environment, or a wrapper that decides nothing but observations and time."""
    if not isinstance(layer, gymnasium.Wrapper):
        return True
    return isinstance(layer, _TIMERS) and any(type(layer).step is cls.step for cls in _TIMERS)


def copied(env: _Env) -> _Env:
    """A copy that shares spaces, specs and tables: steps do not change them, and they are most of the work."""
    shared = {
        id(part): part
        for layer in layers(env)
        for name, part in vars(layer).items()
        if isinstance(part, spaces.Space | EnvSpec) or is_table(name, part)
    }
    return copy.deepcopy(env, shared)
