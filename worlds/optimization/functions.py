"""Eight test functions from the optimization literature, with exact derivatives."""

import math
from functools import partial

import numpy as np

from worlds.optimization.loss import Gradient, Loss, Point, Value

__all__ = ["LOSSES"]


# The functions take arrays of numbers, too.


def _cos(x: float) -> float:
    return math.cos(x) if isinstance(x, float) else np.cos(x)


def _sin(x: float) -> float:
    return math.sin(x) if isinstance(x, float) else np.sin(x)


_Curvature = tuple[float, float, float]  # second derivatives: by x1 twice, by both, by x2 twice


def _booth(x1: float, x2: float) -> float:
    return (x1 + 2 * x2 - 7) ** 2 + (2 * x1 + x2 - 5) ** 2


def _booth_gradient(x1: float, x2: float) -> Point:
    return 10 * x1 + 8 * x2 - 34, 8 * x1 + 10 * x2 - 38


def _mccormick(x1: float, x2: float) -> float:
    return _sin(x1 + x2) + (x1 - x2) ** 2 - 1.5 * x1 + 2.5 * x2 + 1


def _mccormick_gradient(x1: float, x2: float) -> Point:
    cos, difference = _cos(x1 + x2), 2 * (x1 - x2)
    return cos + difference - 1.5, cos - difference + 2.5


def _mccormick_hessian(x1: float, x2: float) -> _Curvature:
    sin = _sin(x1 + x2)
    return 2 - sin, -2 - sin, 2 - sin


def _rosenbrock(x1: float, x2: float) -> float:
    return (1 - x1) ** 2 + (x2 - x1**2) ** 2


def _rosenbrock_gradient(x1: float, x2: float) -> Point:
    off = x2 - x1**2
    return 2 * (x1 - 1) - 4 * x1 * off, 2 * off


def _rosenbrock_hessian(x1: float, x2: float) -> _Curvature:
    return 2 - 4 * (x2 - x1**2) + 8 * x1**2, -4 * x1, 2.0


def _six_hump_camel(x1: float, x2: float) -> float:
    return (4 - 2.1 * x1**2 + x1**4 / 3) * x1**2 + x1 * x2 + (4 * x2**2 - 4) * x2**2


def _six_hump_camel_gradient(x1: float, x2: float) -> Point:
    return 8 * x1 - 8.4 * x1**3 + 2 * x1**5 + x2, x1 - 8 * x2 + 16 * x2**3


def _six_hump_camel_hessian(x1: float, x2: float) -> _Curvature:
    return 8 - 25.2 * x1**2 + 10 * x1**4, 1.0, 48 * x2**2 - 8


def _bohachevsky_1(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * _cos(_A * x1) - 0.4 * _cos(_B * x2) + 0.7


def _bohachevsky_1_gradient(x1: float, x2: float) -> Point:
    return 2 * x1 + 0.3 * _A * _sin(_A * x1), 4 * x2 + 0.4 * _B * _sin(_B * x2)


def _bohachevsky_1_hessian(x1: float, x2: float) -> _Curvature:
    return 2 + 0.3 * _A**2 * _cos(_A * x1), 0.0, 4 + 0.4 * _B**2 * _cos(_B * x2)


def _bohachevsky_2(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * _cos(_A * x1) * _cos(_B * x2) + 0.3


def _bohachevsky_2_gradient(x1: float, x2: float) -> Point:
    return (
        2 * x1 + 0.3 * _A * _sin(_A * x1) * _cos(_B * x2),
        4 * x2 + 0.3 * _B * _cos(_A * x1) * _sin(_B * x2),
    )


def _bohachevsky_2_hessian(x1: float, x2: float) -> _Curvature:
    cosines = 0.3 * _cos(_A * x1) * _cos(_B * x2)
    return 2 + _A**2 * cosines, -0.3 * _A * _B * _sin(_A * x1) * _sin(_B * x2), 4 + _B**2 * cosines


def _bohachevsky_3(x1: float, x2: float) -> float:
    return x1**2 + 2 * x2**2 - 0.3 * _cos(_A * x1 + _B * x2) + 0.3


def _bohachevsky_3_gradient(x1: float, x2: float) -> Point:
    sin = 0.3 * _sin(_A * x1 + _B * x2)
    return 2 * x1 + _A * sin, 4 * x2 + _B * sin


def _bohachevsky_3_hessian(x1: float, x2: float) -> _Curvature:
    cos = 0.3 * _cos(_A * x1 + _B * x2)
    return 2 + _A**2 * cos, _A * _B * cos, 4 + _B**2 * cos


def _rotated_hyper_ellipsoid(x1: float, x2: float) -> float:
    return 2 * x1**2 + x2**2


def _rotated_hyper_ellipsoid_gradient(x1: float, x2: float) -> Point:
    return 4 * x1, 2 * x2


def _matyas(x1: float, x2: float) -> float:
    return 0.26 * (x1**2 + x2**2) - 0.48 * x1 * x2


def _matyas_gradient(x1: float, x2: float) -> Point:
    return 0.52 * x1 - 0.48 * x2, 0.52 * x2 - 0.48 * x1


def _three_hump_camel(x1: float, x2: float) -> float:
    return 2 * x1**2 - 1.05 * x1**4 + x1**6 / 6 + x1 * x2 + x2**2


def _three_hump_camel_gradient(x1: float, x2: float) -> Point:
    return 4 * x1 - 4.2 * x1**3 + x1**5 + x2, x1 + 2 * x2


def _three_hump_camel_hessian(x1: float, x2: float) -> _Curvature:
    return 4 - 12.6 * x1**2 + 5 * x1**4, 1.0, 2.0


def _constant(curvature: _Curvature, x1: float, x2: float) -> _Curvature:
    return curvature


def _square(
    value: Value, gradient: Gradient, hessian: Gradient | _Curvature, low: float, high: float, *minimisers: Point
) -> Loss:
    if isinstance(hessian, tuple):
        hessian = partial(_constant, hessian)
    return Loss(value, gradient, hessian, (low, low), (high, high), minimisers)


_A, _B = 3 * math.pi, 4 * math.pi
_CAMEL = (0.08984201310031807, -0.7126564030207396)
LOSSES: dict[str, tuple[Loss, ...]] = {
    "Booth": (_square(_booth, _booth_gradient, (10.0, 8.0, 10.0), -10.0, 10.0, (1.0, 3.0)),),
    # On LLF-Bench's square the minimum is at the edge; the unbounded minimiser (-0.547, -1.547) lies outside.
    "McCormick": (
        _square(_mccormick, _mccormick_gradient, _mccormick_hessian, -1.5, 4.0, (-0.5288833955428878, -1.5)),
    ),
    "Rosenbrock": (_square(_rosenbrock, _rosenbrock_gradient, _rosenbrock_hessian, -5.0, 10.0, (1.0, 1.0)),),
    "SixHumpCamel": (
        _square(
            _six_hump_camel,
            _six_hump_camel_gradient,
            _six_hump_camel_hessian,
            -2.0,
            2.0,
            _CAMEL,
            (-_CAMEL[0], -_CAMEL[1]),
        ),
    ),
    "Bohachevsky": (
        _square(_bohachevsky_1, _bohachevsky_1_gradient, _bohachevsky_1_hessian, -100.0, 100.0, (0.0, 0.0)),
        _square(_bohachevsky_2, _bohachevsky_2_gradient, _bohachevsky_2_hessian, -100.0, 100.0, (0.0, 0.0)),
        _square(_bohachevsky_3, _bohachevsky_3_gradient, _bohachevsky_3_hessian, -100.0, 100.0, (0.0, 0.0)),
    ),
    "RotatedHyperEllipsoid": (
        _square(
            _rotated_hyper_ellipsoid, _rotated_hyper_ellipsoid_gradient, (4.0, 0.0, 2.0), -65.536, 65.536, (0.0, 0.0)
        ),
    ),
    "Matyas": (_square(_matyas, _matyas_gradient, (0.52, -0.48, 0.52), -10.0, 10.0, (0.0, 0.0)),),
    "ThreeHumpCamel": (
        _square(_three_hump_camel, _three_hump_camel_gradient, _three_hump_camel_hessian, -5.0, 5.0, (0.0, 0.0)),
    ),
}
"""The losses by LLF-Bench's names, each with its variants (`func_choice`)."""
