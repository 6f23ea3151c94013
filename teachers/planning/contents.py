"""The key of an environment's state, where nobody gives one: all that the environment holds."""

import copy
import hashlib
import pickle
from collections.abc import Callable, Hashable, Iterator, Mapping, Set
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces, wrappers
from gymnasium.envs.registration import EnvSpec

from teachers.planning.known import State
from teachers.planning.planner import PlanningError
from worlds.wrapped.snapshots import GENERATORS, is_table

_Env = gymnasium.Env[Any, Any]
_TRIAL = 20  # steps of random play, which show what counts steps, and what changes
_COMMON = {"metadata", "render_mode", "spec", "_np_random_seed", "reward_range"}
_TOY = {"initial_state_distrib", "lastaction"}  # of Gymnasium's toy texts; the last is for pictures
_DRAWN = {"window", "clock", "screen"}  # of Gymnasium's pictures; another's `clock` may count
_FIXED = *GENERATORS, spaces.Space, EnvSpec, type  # no part of the state: draws to come are not to be known
_TIMERS = wrappers.TimeLimit, wrappers.OrderEnforcing, wrappers.PassiveEnvChecker  # without a state but time
HINT = "pass oracle=Exact(state=f) of teachers.planning, where f(env) is all that decides what happens, hashable"
"""What gives a key in its place."""


@dataclass(frozen=True)
class Contents:
    """The key of a state: a digest of an environment's attributes, or of what its `get_state()` returns.

    It may tell apart states that are the same, which costs time; states that differ in these attributes it never takes
    for one.
    """

    counts: tuple[str, ...] = ()
    """The attributes that count steps."""
    timed: bool = True
    """Whether these are part of the key."""
    asks: bool = False
    """Whether it calls `get_state()`, rather than look at attributes."""
    strict: bool = True
    """Whether values of unknown classes raise; else they are compared by what pickle writes of them, if it can."""

    def __call__(self, env: _Env) -> bytes:
        """Read the state; errors as `parts`."""
        return hashlib.blake2b(repr(self.parts(env)).encode(), digest_size=16).digest()

    def parts(self, env: _Env) -> tuple[tuple[str, Hashable], ...]:
        """What is in the key, by name.

        Raises:
            PlanningError: a value cannot be compared.
        """
        if self.asks:
            bare: Any = env.unwrapped
            return (("get_state()", self._read("what get_state() returns", bare.get_state())),)
        return tuple(
            (name, self._read(f"the attribute {name!r}", value))
            for name, value in sorted(vars(env.unwrapped).items())
            if not _is_fixed(name, value) and (self.timed or name not in self.counts)
        )

    def _read(self, what: str, value: Any) -> Hashable:
        try:
            return _still(value)
        except TypeError as error:
            if self.strict:
                raise PlanningError(f"{what} has {error}; {HINT}") from None
        try:
            return None if hasattr(value, "random") else pickle.dumps(value)  # a generator is no part of the state
        except Exception:  # such as a window of an environment that was drawn since
            return None


def contents_of(env: _Env) -> Contents:
    """A key for searches: of all attributes but those that count steps.

    Args:
        env: an environment, which is reset and stepped.
    """
    return Contents(_counts(env), timed=False, strict=False)


def certain_contents(env: _Env) -> Contents:
    """A key that tells apart all states that differ.

    Args:
        env: an environment, which is reset and stepped.

    Raises:
        PlanningError: an attribute is of a kind that cannot be compared, or a wrapper may have a state of its own.
    """
    asks = callable(getattr(env.unwrapped, "get_state", None))
    layer: Any = env
    while isinstance(layer, gymnasium.Wrapper) and not asks:
        if not isinstance(layer, _TIMERS):
            raise PlanningError(f"the wrapper {type(layer).__name__} may have a state of its own; {HINT}")
        layer = layer.env
    return Contents(() if asks else _counts(env), asks=asks)


def check_recurs(env: _Env, state: State) -> None:
    """Play at random, and look at what changes.

    Raises:
        PlanningError: it has real numbers, which hardly recur; or the state cannot be read.
    """

    def read(env: _Env) -> dict[str, Any]:
        return dict(state.parts(env)) if isinstance(state, Contents) else {"": state(env)}

    for before, after in _steps(env, read):
        for name, value in after.items():
            if before.get(name) != value and _is_real(value):
                where = name and f" in {name}"
                raise PlanningError(f"its state has real numbers{where}, which hardly recur; {HINT}")


def _counts(env: _Env) -> tuple[str, ...]:
    """The attributes that count steps."""
    grown = [
        {name for name, value in before.items() if type(value) is int and after.get(name) == value + 1}
        for before, after in _steps(env, lambda env: dict(vars(env.unwrapped)))
    ]
    return tuple(sorted(set.intersection(*grown)))


def _steps(env: _Env, read: Callable[[_Env], dict[str, Any]]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """What is read before and after each step of random play."""
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    env.reset(seed=0)
    for _ in range(_TRIAL):
        before = read(env)
        _, _, terminated, truncated, _ = env.step(space.sample())
        yield before, read(env)
        if terminated or truncated:
            env.reset(seed=0)


def _is_fixed(name: str, value: Any) -> bool:
    """Whether an attribute is no part of the state."""
    if name in _COMMON | _TOY or isinstance(value, _FIXED) or is_table(name, value):
        return True
    if name in _DRAWN and (value is None or type(value).__module__.startswith("pygame")):
        return True
    return callable(value) and not getattr(value, "__dict__", None)  # a function


def _still(value: Any) -> Hashable:
    """A value whose `repr` is the same for equal ones.

    Raises:
        TypeError: there is none.
    """
    if isinstance(value, np.generic) and not isinstance(number := value.item(), np.generic):
        return _still(number)
    if value is None or isinstance(value, str | bytes | int | float):
        return value
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.shape, str(value.dtype), value.tobytes()
    if isinstance(value, Mapping):
        return tuple((_still(key), _still(each)) for key, each in value.items())
    if isinstance(value, Set):
        return tuple(sorted(map(_still, value), key=repr))
    if isinstance(value, list | tuple):
        return tuple(map(_still, value))
    raise TypeError(f"a value of class {type(value).__name__}, which cannot be compared")


def _is_real(value: Any) -> bool:
    """Whether a value has real numbers that are not whole."""
    if isinstance(value, float):
        return not value.is_integer()
    if isinstance(value, tuple) and len(value) == 3 and isinstance(value[1], str) and isinstance(value[2], bytes):
        return np.dtype(value[1]).kind == "f" and bool((np.frombuffer(value[2], value[1]) % 1 != 0).any())
    return isinstance(value, tuple) and any(map(_is_real, value))
