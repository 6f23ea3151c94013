"""The key of an environment's state, where nobody gives one: from what the environment itself has."""

from collections.abc import Hashable, Mapping, Set
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces, wrappers

from teachers.planning.known import State
from teachers.planning.planner import PlanningError

_Env = gymnasium.Env[Any, Any]
_PLAIN = (wrappers.TimeLimit, wrappers.OrderEnforcing, wrappers.PassiveEnvChecker)  # without a state but time
_STEPS = 20  # of random play, in which the parts that change are looked at


def own_state(env: _Env) -> State:
    """A function that reads the state: by `get_state()`, or else all attributes of the environment but its generator.

    Raises:
        PlanningError: an attribute is of a kind that cannot be compared, or real numbers change, which hardly recur.
    """
    hint = "pass oracle=Exact(state=f) of teachers.planning, where f(env) is all that decides what happens, hashable"
    if callable(getattr(env.unwrapped, "get_state", None)):
        return _given
    layer: Any = env
    while isinstance(layer, gymnasium.Wrapper):
        if not isinstance(layer, _PLAIN):
            raise PlanningError(f"the wrapper {type(layer).__name__} may have a state of its own; {hint}")
        layer = layer.env
    try:
        _check_recurs(env)
    except TypeError as error:
        raise PlanningError(f"{error}; {hint}") from None
    return _attributes


def _check_recurs(env: _Env) -> None:
    """Play at random, and look at what changes.

    Raises:
        TypeError: it has real numbers.
    """
    env.action_space.seed(0)
    env.reset(seed=0)
    before = dict(_attributes(env))
    for _ in range(_STEPS):
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        for name, value in _attributes(env):
            if before.get(name) != value and _real(value):
                raise TypeError(f"its state has real numbers, which hardly recur: the attribute {name!r}")
        if terminated or truncated:
            env.reset()


def _given(env: _Env) -> Hashable:
    return _still(env.unwrapped.get_state())  # type: ignore[attr-defined]  # some have it


def _attributes(env: _Env) -> tuple[tuple[str, Hashable], ...]:
    """All attributes by name, but for what belongs to every environment.

    Raises:
        TypeError: one cannot be compared.
    """
    found = []
    for name, value in sorted(vars(env.unwrapped).items()):
        if isinstance(value, np.random.Generator | spaces.Space) or callable(value) or name in _COMMON:
            continue
        if name in _DRAWN and (value is None or type(value).__module__.startswith("pygame")):
            continue
        try:
            found.append((name, _still(value)))
        except TypeError as error:
            raise TypeError(f"its attribute {name!r} has {error}") from None
    return tuple(found)


_COMMON = {"metadata", "render_mode", "spec", "_np_random_seed", "reward_range"}
_DRAWN = {"window", "clock", "screen"}  # of Gymnasium's pictures; another's `clock` may count


def _still(value: Any) -> Hashable:
    """A hashable value that is equal for equal ones.

    Raises:
        TypeError: there is none.
    """
    if value is None or isinstance(value, str | bytes | bool | int | float):
        return value
    if isinstance(value, np.generic):
        return _still(value.item())
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.shape, str(value.dtype), value.tobytes()
    if isinstance(value, Mapping):
        return tuple((_still(key), _still(each)) for key, each in value.items())
    if isinstance(value, Set):
        return frozenset(map(_still, value))
    if isinstance(value, list | tuple):
        return tuple(map(_still, value))
    raise TypeError(f"a value of class {type(value).__name__}, which cannot be compared")


def _real(value: Hashable) -> bool:
    """Whether a value has real numbers that are not whole."""
    if isinstance(value, float):
        return not value.is_integer()
    if isinstance(value, tuple) and len(value) == 3 and isinstance(value[1], str) and isinstance(value[2], bytes):
        return np.dtype(value[1]).kind == "f" and bool((np.frombuffer(value[2], value[1]) % 1 != 0).any())
    return isinstance(value, tuple | frozenset) and any(map(_real, value))
