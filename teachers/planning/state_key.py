"""The default key of an environment's state for the tier `exact`: all that the environment holds."""

import copy
import hashlib
import io
import pickle
from collections.abc import Callable, Hashable, Iterator, Mapping, Set
from dataclasses import dataclass
from functools import partial
from types import BuiltinFunctionType, FunctionType, MethodType, ModuleType
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec

from teachers.planning.known import State
from teachers.planning.planner import PlanningError, stepped
from worlds.wrapped.generators import is_generator, of_function
from worlds.wrapped.layers import is_plain, layers

_Env = gymnasium.Env[Any, Any]
_TRIAL = 20  # steps of random play, which shows what counts steps, and what changes
_DEPTH = 50  # of what holds each other
_COMMON = {"metadata", "render_mode", "spec", "_np_random_seed", "reward_range"}
_TOYS = "gymnasium.envs.toy_text."
_TOY = {"P", "initial_state_distrib", "lastaction"}  # of these, where they decide nothing that changes
_DRAWN = {"window", "clock", "screen"}  # of Gymnasium's pictures; another's `clock` may count
_FIXED = spaces.Space, EnvSpec  # no part of the state
_LAST: list[tuple[Any, bytes]] = []  # the table that was read last, and its digest
HINT = "pass oracle=Exact(state=f) of teachers.planning, where f(env) is all that decides what happens, hashable"
"""Advice to give a key of one's own."""


@dataclass(frozen=True)
class StateKey:
    """The key of a state: a digest of an environment's attributes, or of what its `get_state()` returns.

    States that differ in these have different keys. The key may also distinguish equivalent states, which costs time.
    """

    counts: tuple[str, ...] = ()
    """The attributes that count steps; the key includes them."""
    asks: bool = False
    """Whether it calls `get_state()` in place of reading attributes."""

    def __call__(self, env: _Env) -> bytes:
        """Read the state; errors as in `parts`."""
        return hashlib.blake2b(repr(self.parts(env)).encode(), digest_size=16).digest()

    def parts(self, env: _Env) -> dict[str, Hashable]:
        """The parts of the key, by name.

        Raises:
            PlanningError: a value cannot be compared.
        """
        if self.asks:
            bare: Any = env.unwrapped
            return {"get_state()": _read("what get_state() returns", bare.get_state())}
        return {name: _read(f"the attribute {name!r}", value) for name, value in sorted(_changeable(env).items())}


def state_key(env: _Env) -> StateKey:
    """A key that distinguishes all different states.

    Args:
        env: an environment, which is reset and stepped.

    Raises:
        PlanningError: stepping it fails.
    """
    asks = callable(getattr(env.unwrapped, "get_state", None))
    return StateKey(() if asks else counts_of(env), asks)


def other_parts(env: _Env, left_out: Set[str]) -> dict[str, Hashable]:
    """Attributes of an environment and its wrappers except `left_out`, by name; None for incomparable values."""
    return {name: _read_or_pickle(value) for name, value in _changeable(env).items() if name not in left_out}


def check_wrappers(env: _Env) -> None:
    """Check that no wrapper of an environment has a state of its own.

    Raises:
        PlanningError: a wrapper may have a state.
    """
    for layer in layers(env):
        if not is_plain(layer):
            raise PlanningError(f"the wrapper {type(layer).__name__} may have a state of its own; {HINT}")


def check_recurs(env: _Env, state: State) -> None:
    """Check by random play that states can recur.

    Raises:
        PlanningError: changing attributes hold real numbers, which hardly recur; or the state cannot be read.
    """

    def read(env: _Env) -> dict[str, Any]:
        return state.parts(env) if isinstance(state, StateKey) else {"": state(env)}

    for before, after in _steps(env, read):
        for name, value in after.items():
            if before.get(name) != value and _is_real(value):
                where = name and f" in {name}"
                raise PlanningError(f"its state has real numbers{where}, which hardly recur; {HINT}")


def counts_of(env: _Env) -> tuple[str, ...]:
    """The attributes that count steps."""
    grown = [
        {name for name, value in before.items() if type(value) is int and after.get(name) == value + 1}
        for before, after in _steps(env, lambda env: _held(env.unwrapped))
    ]
    return tuple(sorted(set.intersection(*grown)))


def _steps(env: _Env, read: Callable[[_Env], dict[str, Any]]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """The values that `read` returns before and after each step of random play."""
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    env.reset(seed=0)
    for _ in range(_TRIAL):
        before = read(env)
        _, _, terminated, truncated, _ = stepped(env, space.sample())
        yield before, read(env)
        if terminated or truncated:
            env.reset(seed=0)


def _read(what: str, value: Any) -> Hashable:
    """A value in comparable form.

    Raises:
        PlanningError: it cannot be compared.
    """
    try:
        return _of_table(value) if what == "the attribute 'P'" and isinstance(value, Mapping) else comparable(value)
    except (TypeError, ValueError) as error:
        raise PlanningError(f"{what} has {error}; {HINT}") from None


def _read_or_pickle(value: Any) -> Hashable:
    """A value in comparable form, else its pickle; None if neither exists."""
    try:
        return comparable(value)
    except (TypeError, ValueError):
        written = io.BytesIO()
    try:
        _Pickler(written).dump(value)
        return written.getvalue()
    except Exception:  # such as a window of an environment that was drawn since
        return None


def _changeable(env: _Env) -> dict[str, Any]:
    """The attributes of an environment and its wrappers that may be state, by name."""
    toy = type(env.unwrapped).__module__.startswith(_TOYS)
    return {name: value for name, value in _attributes(env).items() if not _is_fixed(name, value, toy)}


def _attributes(env: _Env) -> dict[str, Any]:
    """All attributes of an environment and its wrappers, by name: of instances, in slots, and of classes.

    Class attributes count only if they are mutable.
    """
    found: dict[str, Any] = {}
    for layer in layers(env):
        if layer is env.unwrapped:
            found |= _held(layer)
        elif not is_plain(layer):
            found |= {f"{name} of {layer.class_name()}": each for name, each in _held(layer).items() if name != "env"}
    return found


def _held(layer: Any) -> dict[str, Any]:
    own: Any = object.__getstate__(layer)  # a dict, or a tuple with the slots
    attributes, slots = own if isinstance(own, tuple) else (own, None)
    return _shared(type(layer)) | (slots or {}) | (attributes or {})


def _shared(cls: type) -> dict[str, Any]:
    return {
        f"{each.__qualname__}.{name}": value
        for each in cls.__mro__
        if not each.__module__.startswith("gymnasium.")
        for name, value in vars(each).items()
        if isinstance(value, list | dict | set | np.ndarray) and name[:2] != "__" and name not in _COMMON
    }


class _Pickler(pickle.Pickler):
    """Pickles objects without their random generators, which are not state."""

    def persistent_id(self, value: Any) -> str | None:
        return "generator" if is_generator(value) else None


def _is_fixed(name: str, value: Any, toy: bool) -> bool:
    """Whether an attribute is certainly not state."""
    if name in _COMMON or (toy and name in _TOY) or isinstance(value, _FIXED):
        return True
    if is_generator(value):  # draws to come are not to be known
        return True
    return name in _DRAWN and (value is None or type(value).__module__.startswith("pygame"))


def comparable(value: Any, around: tuple[int, ...] = ()) -> Hashable:
    """A value in a form that can be compared and hashed; equal values have the same `repr`.

    Args:
        value: the value.
        around: the ids of the containers around it, to detect a value that contains itself.

    Raises:
        TypeError: the value has no such form.
    """
    if isinstance(value, np.generic) and not isinstance(number := value.item(), np.generic):
        return comparable(number)
    if value is None or isinstance(value, str | bytes | int | float):
        return value
    if isinstance(value, np.ndarray) and value.dtype != object:
        return value.shape, str(value.dtype), value.tobytes()
    if id(value) in around:
        return "itself", around.index(id(value))
    if len(around) > _DEPTH:
        raise TypeError(f"values that hold each other more than {_DEPTH} times, which cannot be compared")
    inner = partial(comparable, around=(*around, id(value)))
    if isinstance(value, Mapping):
        return tuple((inner(key), inner(each)) for key, each in value.items())
    if isinstance(value, Set):
        return tuple(sorted(map(inner, value), key=repr))
    if isinstance(value, list | tuple):
        return tuple(map(inner, value))
    if isinstance(value, MethodType) and isinstance(value.__self__, gymnasium.Env):
        return inner(value.__func__)
    if isinstance(value, FunctionType):
        code = value.__code__
        return _named(value), code.co_firstlineno, code.co_code, repr(code.co_consts), inner(of_function(value))
    if isinstance(value, partial):
        return inner((value.func, value.args, value.keywords))
    if isinstance(value, type | np.ufunc) or (
        isinstance(value, BuiltinFunctionType) and isinstance(value.__self__, ModuleType)
    ):
        return _named(value)
    raise TypeError(f"a value of class {type(value).__name__}, which cannot be compared")


def _of_table(table: Mapping[Any, Any]) -> Hashable:
    """A short form of a large table; a table equal to the last one is not read again."""
    if not _LAST or _LAST[0][0] != table:
        _LAST[:] = [(unshared(table), hashlib.blake2b(repr(comparable(table)).encode(), digest_size=16).digest())]
    return _LAST[0][1]


def unshared(table: Any) -> Any:
    """A copy of the mutable parts of a table."""
    if isinstance(table, Mapping):
        return {key: unshared(each) for key, each in table.items()}
    return list(map(unshared, table)) if isinstance(table, list) else table


def _named(value: Any) -> str:
    """The name of a function or a class."""
    return f"{getattr(value, '__module__', '')}:{getattr(value, '__qualname__', value.__name__)}"


def _is_real(value: Any) -> bool:
    """Whether a value contains real numbers that are not whole."""
    if isinstance(value, float):
        return not value.is_integer()
    if isinstance(value, tuple) and len(value) == 3 and isinstance(value[1], str) and isinstance(value[2], bytes):
        return np.dtype(value[1]).kind == "f" and bool((np.frombuffer(value[2], value[1]) % 1 != 0).any())
    return isinstance(value, tuple) and any(map(_is_real, value))
