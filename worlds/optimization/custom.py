"""Custom losses: derivatives and minimiser are estimated unless they are given."""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np

from worlds.optimization.loss import Gradient, Loss, Point, Value

_GRID = 41  # points along each axis in the first evaluation of a loss
_STARTS = 8  # the search for the minimum starts from so many best points


def custom_loss(function: Value, choice: int, gradient: Gradient | None, domain: Any, minimiser: Any) -> Loss:
    """Make a loss of a function.

    Raises:
        ValueError: an argument is not allowed, the function is not finite on its domain, or a point of it has a lower
            value than the given minimiser.
    """
    if choice != 1:
        raise ValueError(f"func_choice applies to Bohachevsky only, got {choice!r} for a custom function; allowed: 1")
    try:
        first, second = domain
        bounds = (first, second) if isinstance(first, Sequence) else ((first, second), (first, second))
        lows, highs = tuple(zip(*((float(low), float(high)) for low, high in bounds), strict=True))
        if not all(low < high and math.isfinite(high - low) for low, high in zip(lows, highs, strict=True)):
            raise ValueError
    except (TypeError, ValueError):
        raise ValueError(
            f"domain of a custom function must be (low, high) or ((low, high), (low, high)) with low < high, "
            f"got {domain!r}"
        ) from None
    return _loss_of(function, gradient, lows, highs, None if minimiser is None else tuple(map(float, minimiser)))


@lru_cache(maxsize=64)  # scratch worlds share it
def _loss_of(function: Value, gradient: Gradient | None, lows: Point, highs: Point, minimiser: Point | None) -> Loss:
    value = partial(_number, function)
    slope = gradient or partial(_differences, value, lows, highs)
    hessian = partial(_curvature, slope, lows, highs)
    grid = product(*(np.linspace(low, high, _GRID).tolist() for low, high in zip(lows, highs, strict=True)))
    seen = sorted((value(*point), point) for point in grid)
    if minimiser is None:
        minimisers = _search(value, slope, lows, highs, [point for _, point in seen[:_STARTS]])
    elif len(minimiser) != 2 or not all(lows[i] <= minimiser[i] <= highs[i] for i in (0, 1)):
        raise ValueError(f"minimiser must be a point of the domain, got {minimiser!r}")
    elif seen[0][0] < value(*minimiser):
        raise ValueError(
            f"minimiser must be the point of least loss, got {minimiser}; the loss is less at {seen[0][1]}"
        )
    else:
        minimisers = (minimiser,)
    return Loss(value, slope, hessian, lows, highs, minimisers)


def _number(function: Value, x1: float, x2: float) -> float:
    """The value of a function as a Python float."""
    value = float(function(x1, x2))
    if not math.isfinite(value):
        raise ValueError(f"the loss must be finite on its domain, got {value} at [{x1}, {x2}]")
    return value


def _differences(function: Callable[..., Any], lows: Point, highs: Point, x1: float, x2: float) -> tuple[Any, ...]:
    """First derivatives of a function of two numbers, estimated by central differences within the domain."""
    slopes = []
    for i in range(2):
        x = (x1, x2)[i]
        step = 1e-6 * (highs[i] - lows[i])
        below, above = max(x - step, lows[i]), min(x + step, highs[i])
        at = (lambda z: (z, x2), lambda z: (x1, z))[i]
        slopes.append((function(*at(above)) - function(*at(below))) / (above - below))
    return tuple(slopes)


def _curvature(gradient: Gradient, lows: Point, highs: Point, x1: float, x2: float) -> tuple[float, float, float]:
    """Second derivatives, estimated from first ones, with a wider step since these may be estimates, too."""
    rows = []
    for i in range(2):
        x = (x1, x2)[i]
        step = 1e-3 * (highs[i] - lows[i])
        below, above = max(x - step, lows[i]), min(x + step, highs[i])
        at = (lambda z: (z, x2), lambda z: (x1, z))[i]
        ends = zip(gradient(*at(above)), gradient(*at(below)), strict=True)
        rows.append([(float(up) - float(down)) / (above - below) for up, down in ends])
    return rows[0][0], (rows[0][1] + rows[1][0]) / 2, rows[1][1]


def _search(value: Value, gradient: Gradient, lows: Point, highs: Point, starts: list[Point]) -> tuple[Point, ...]:
    """The points of least loss that scipy finds from these starting points."""
    from scipy.optimize import minimize

    found = []
    for start in starts:
        result = minimize(
            lambda x: value(*x.tolist()),
            start,
            jac=lambda x: np.array(gradient(*x.tolist()), float),
            bounds=list(zip(lows, highs, strict=True)),
            method="L-BFGS-B",
            options={"ftol": 1e-15, "gtol": 1e-10},
        )
        found += [(value(*point), point) for point in (start, tuple(result.x.tolist()))]
    least, best = min(found)
    minimisers = [best]
    for y, point in sorted(found):
        apart = min(max(abs(point[i] - m[i]) / (highs[i] - lows[i]) for i in range(2)) for m in minimisers)
        if y - least <= 1e-9 * (1 + abs(least)) and apart > 1e-3:
            minimisers.append(point)
    return tuple(minimisers)
