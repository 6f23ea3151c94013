"""Actions of any Gymnasium space in a canonical form: hashable values that JSON can represent.

Numbers are Python's, arrays are tuples, dicts are tuples of pairs. Each function dispatches on the type of the space.
"""

import contextlib
import copy
import math
from collections.abc import Callable, Mapping
from functools import singledispatch
from typing import Any

import numpy as np
from gymnasium import spaces

__all__ = ["canonical", "describe_space", "format_value", "inward", "is_element", "native", "syntax"]


@singledispatch
def canonical(space: spaces.Space[Any], action: Any) -> Any:
    """Convert an action to canonical form.

    Raises:
        ValueError, TypeError: the action is not in the space.
    """
    return _member(space, action)


@singledispatch
def native(space: spaces.Space[Any], action: Any) -> Any:
    """Convert an action from canonical form to the form that the environment takes."""
    return action


@singledispatch
def syntax(space: spaces.Space[Any]) -> str:
    """Describe the text form of an action, to complete "the answer must be ...".

    Raises:
        ValueError: actions of this space cannot be written as text.
    """
    return f"an element of {describe_space(space)}"


def describe_space(space: spaces.Space[Any]) -> str:
    """The text of a space as Gymnasium shows it; if that has a memory address, the class name and an element."""
    if isinstance(space, spaces.Dict):
        return f"Dict({', '.join(f'{name!r}: {describe_space(part)}' for name, part in space.items())})"
    if isinstance(space, spaces.Tuple):
        return f"Tuple({', '.join(map(describe_space, space))})"
    text = f"{space}"
    if " at 0x" not in text:
        return text
    name = type(space).__name__
    drawn = copy.deepcopy(space)  # the space's own stream of random numbers stays where it is
    with contextlib.suppress(Exception):  # a space of the user's own may fail in any way
        drawn.seed(0)
        return f"{name}, such as {drawn.sample()!r}"
    return name


def is_element(space: spaces.Space[Any], action: Any) -> bool:
    """Whether the action is in the space. A bool is not, although Gymnasium takes it for 0 or 1."""
    # Gymnasium's own check takes six times as long.
    if type(space) is spaces.Discrete and type(action) in (int, space.dtype.type):
        return 0 <= int(action) - int(space.start) < int(space.n)
    return not isinstance(action, bool) and space.contains(action)


def _member(space: spaces.Space[Any], action: Any) -> Any:
    if not is_element(space, action):
        raise ValueError(f"{action!r} is not in {space}")
    return action


@canonical.register
def _(space: spaces.Discrete, action: Any) -> int:
    return int(_member(space, action))


@syntax.register
def _(space: spaces.Discrete) -> str:
    return f"an integer from {space.start} to {space.start + space.n - 1}"


@canonical.register(spaces.Box)
@canonical.register(spaces.MultiBinary)
@canonical.register(spaces.MultiDiscrete)
def _(space: Any, action: Any) -> Any:
    if isinstance(action, bytes | bytearray | memoryview):  # which NumPy takes for arrays
        raise TypeError(f"{action!r} is not made of numbers")
    given = np.asarray(action)
    if given.dtype.kind not in "iuf":
        raise ValueError(f"{action!r} is not made of numbers")
    with np.errstate(all="ignore"):  # out of range becomes infinite or another number, refused below
        array = given.astype(space.dtype)
    if not np.isfinite(array).all():
        raise ValueError(f"{action!r} is not finite")
    if space.dtype.kind != "f" and (array != given).any():
        raise ValueError(f"{action!r} is not made of integers")
    return _tuples(_member(space, array).tolist())


@native.register(spaces.Box)
@native.register(spaces.MultiBinary)
@native.register(spaces.MultiDiscrete)
def _(space: Any, action: Any) -> np.ndarray:
    return np.array(action, space.dtype)


@syntax.register
def _(space: spaces.Box) -> str:
    low, high = space.low, space.high
    noun = "number" if space.dtype.kind == "f" else "integer"
    one = space.shape == () or ((low == low.flat[0]).all() and (high == high.flat[0]).all())
    bounds = (
        _bounds(low.flat[0].item(), high.flat[0].item(), space.dtype.type)
        if one
        else f", from {low.tolist()} to {high.tolist()}"
    )
    if space.shape == ():
        return f"{'a' if noun == 'number' else 'an'} {noun}{bounds}"
    return f"{_listing(space.shape, noun)}{', each' if one and bounds else ''}{bounds}"


@syntax.register
def _(space: spaces.MultiBinary) -> str:
    return f"{_listing(space.shape, 'integer')}, each 0 or 1"


@syntax.register
def _(space: spaces.MultiDiscrete) -> str:
    return (
        f"{_listing(space.shape, 'integer')}, from {space.start.tolist()} to {(space.start + space.nvec - 1).tolist()}"
    )


@canonical.register(spaces.Tuple)
def _(space: Any, action: Any) -> tuple[Any, ...]:
    if not isinstance(action, list | tuple):
        raise TypeError(f"{action!r} is not a list or tuple")
    return tuple(canonical(part, item) for part, item in zip(space.spaces, action, strict=True))


@native.register(spaces.Tuple)
def _(space: Any, action: Any) -> tuple[Any, ...]:
    return tuple(native(part, item) for part, item in zip(space.spaces, action, strict=True))


@syntax.register(spaces.Tuple)
def _(space: Any) -> str:
    return f"a list of {'; '.join(map(syntax, space.spaces))}"


@canonical.register
def _(space: spaces.Dict, action: Any) -> tuple[tuple[str, Any], ...]:
    items = dict(action)
    if items.keys() != space.spaces.keys():
        raise ValueError(f"{action!r} has other keys than {space}")
    return tuple((key, canonical(part, items[key])) for key, part in space.spaces.items())


@native.register
def _(space: spaces.Dict, action: Any) -> dict[str, Any]:
    return {key: native(space.spaces[key], item) for key, item in action}


@syntax.register
def _(space: spaces.Dict) -> str:
    if not all(isinstance(key, str) for key in space.spaces):
        raise ValueError(
            f"actions of {space} cannot be written as text: a key is not a string; allowed: keys that are strings"
        )
    parts = (f'"{key}": {syntax(part)}' for key, part in space.spaces.items())
    return f"a JSON object with {'; '.join(parts)}"


@canonical.register(spaces.Sequence)
def _(space: Any, action: Any) -> tuple[Any, ...]:
    if not isinstance(action, list | tuple):
        raise TypeError(f"{action!r} is not a list or tuple")
    return tuple(canonical(space.feature_space, item) for item in action)


@native.register(spaces.Sequence)
def _(space: Any, action: Any) -> tuple[Any, ...]:
    return tuple(native(space.feature_space, item) for item in action)


@syntax.register(spaces.Sequence)
def _(space: Any) -> str:
    if space.stack:
        raise ValueError(f"actions of {space} cannot be written as text; allowed: a Sequence without stack=True")
    return f"a list of any length, of which each item is {syntax(space.feature_space)}"


@canonical.register(spaces.OneOf)
def _(space: Any, action: Any) -> tuple[int, Any]:
    if not isinstance(action, list | tuple):
        raise TypeError(f"{action!r} is not a list or tuple")
    number, item = action
    which = canonical(spaces.Discrete(len(space.spaces)), number)
    return which, canonical(space.spaces[which], item)


@native.register(spaces.OneOf)
def _(space: Any, action: Any) -> tuple[int, Any]:
    number, item = action
    return number, native(space.spaces[number], item)


@syntax.register(spaces.OneOf)
def _(space: Any) -> str:
    choices = (f"[{number}, {syntax(part)}]" for number, part in enumerate(space.spaces))
    return f"a list of two, one of {'; '.join(choices)}"


@syntax.register
def _(space: spaces.Graph) -> str:
    raise ValueError(f"actions of {space} cannot be written as text; allowed: spaces other than Graph")


@syntax.register
def _(space: spaces.Text) -> str:
    return f"a text of at most {space.max_length} characters"


def format_value(value: Any, whole: int = 200) -> str:
    """Format an observation as text: numbers with 4 decimals, arrays as lists, dicts with a line per key.

    Arrays of more than `whole` numbers are shortened.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return "\n".join(f"{key}: {format_value(item, whole)}" for key, item in value.items())
    if isinstance(value, np.ndarray) and value.size > whole:
        return np.array2string(value, precision=4, threshold=whole, separator=", ")
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return f"[{', '.join(format_value(item, whole) for item in value)}]"
    return f"{round(value, 4) + 0.0!r}" if isinstance(value, float) else f"{value}"


def inward(low: float, high: float, dtype: Callable[[float], Any] = float) -> tuple[float, float]:
    """The bounds of an interval, rounded for a text: six digits, more for a narrow interval, and never outside it.

    A number counts as inside if `dtype(number)` is.
    """
    return _within(low, low, high, 1, dtype), _within(high, low, high, -1, dtype)


def _within(bound: float, low: float, high: float, way: int, dtype: Callable[[float], Any]) -> float:
    for digits in (6, 9, 12, 15) if bound and math.isfinite(bound) else ():
        unit = 10.0 ** (math.floor(math.log10(abs(bound))) + 1 - digits)
        for near in (bound, bound + way * unit):
            rounded = float(f"{near:.{digits}g}")
            if low <= float(dtype(rounded)) <= high and (rounded == bound or 100 * unit <= high - low):
                return rounded
    return bound


def _bounds(low: float, high: float, dtype: Callable[[float], Any]) -> str:
    if isinstance(low, float):
        low, high = inward(low, high, dtype)
    if np.isfinite(low) and np.isfinite(high):
        return f" from {low:.15g} to {high:.15g}"
    return f" of at least {low:.15g}" if np.isfinite(low) else f" of at most {high:.15g}" if np.isfinite(high) else ""


def _listing(shape: tuple[int, ...], noun: str) -> str:
    if len(shape) == 1:
        return f"a list of {shape[0]} {noun}{'s' if shape[0] != 1 else ''}"
    return f"lists of {noun}s within a list, of shape {shape}"


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
