"""metaworld's own methods with cheaper arithmetic: the same results to the last bit."""

import math
import types
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from worlds.metaworld.state import FloatArray

_FLOATS = (float, np.float64)
_DOUBLE = np.dtype(np.float64)
_STRIDES = (8,)  # of a vector without gaps
_LONG_TAIL = math.sqrt(1 / 0.1 - 1)


def rebound(base: type, names: Mapping[str, Any]) -> type:
    """A subclass of a metaworld environment's class whose methods find these under their names, and itself, too."""
    bound = type(base.__name__, (base,), {})
    names = {**names, base.__name__: bound}
    methods: dict[str, Any] = {}
    for cls in reversed(base.__mro__):
        for name, value in vars(cls).items():
            methods.pop(name, None)
            function = value.__func__ if isinstance(value, staticmethod) else value
            if isinstance(function, types.FunctionType) and names.keys() & set(function.__code__.co_names):
                copy = types.FunctionType(
                    function.__code__, function.__globals__ | names, name, function.__defaults__, function.__closure__
                )
                copy.__kwdefaults__ = function.__kwdefaults__
                methods[name] = staticmethod(copy) if isinstance(value, staticmethod) else copy
    for name, method in methods.items():
        setattr(bound, name, method)
    return bound


def cheaper() -> dict[str, Any]:
    """What metaworld's methods use, by name: scipy's rotations, NumPy's norms and metaworld's tolerances, cheaper."""
    from metaworld.utils import reward_utils

    tolerance = partial(_tolerance, reward_utils.tolerance)
    return {
        "Rotation": _Rotation,
        "np": _Patched(np, linalg=_Patched(np.linalg, norm=_norm)),
        "reward_utils": _Patched(reward_utils, tolerance=tolerance),
        "tolerance": tolerance,
    }


class _Patched:
    """A module with other things under some of its names."""

    def __init__(self, module: types.ModuleType, **instead: Any) -> None:
        self.__dict__.update(vars(module) | instead)
        self._module = module

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


def _norm(x: Any, *more: Any, **named: Any) -> Any:
    """`numpy.linalg.norm`, with its own arithmetic for a vector."""
    if more or named or type(x) is not np.ndarray or x.dtype is not _DOUBLE or x.strides != _STRIDES:
        return np.linalg.norm(x, *more, **named)
    return np.float64(math.sqrt(x.dot(x)))


class _Rotation:
    """`scipy.spatial.transform.Rotation`, as far as metaworld's observations need it: a matrix to a quaternion."""

    def __init__(self, quaternion: FloatArray) -> None:
        self._quaternion = quaternion

    @staticmethod
    def from_matrix(matrix: FloatArray) -> Any:
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

    def as_quat(self) -> FloatArray:
        """x, y, z, w."""
        return self._quaternion


def _is_rotation(rows: Sequence[Sequence[float]]) -> bool:
    """Whether scipy takes a matrix for a rotation, with a margin to its own test."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (
        max(abs(a * d + b * e + c * f), abs(a * g + b * h + c * i), abs(d * g + e * h + f * i)) < 1e-13
        and max(abs(a * a + b * b + c * c - 1), abs(d * d + e * e + f * f - 1), abs(g * g + h * h + i * i - 1)) < 1e-6
        and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0.5
    )


def _tolerance(
    metaworlds: Any, x: Any, bounds: Any = (0.0, 0.0), margin: Any = 0.0, sigmoid: str = "gaussian", **more: Any
) -> Any:
    """metaworld's: 1 within the bounds, less outside; the same arithmetic on plain floats in the common case."""
    low, high = bounds
    if not (sigmoid == "long_tail" and margin > 0 and low <= high and type(x) in _FLOATS and not more):
        return metaworlds(x, bounds, margin, sigmoid, **more)
    x = float(x)
    if low <= x <= high:
        return 1.0
    distance = float((low - x if x < low else x - high) / margin) * _LONG_TAIL
    return 1 / (distance**2 + 1)  # by pow, as NumPy does it with scalars
