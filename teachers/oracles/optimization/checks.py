"""What the claims about proposals are checked by: losses from the simulator, points, and the words for points."""

from collections.abc import Iterator
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from worlds.optimization import Landscape, Optimization, Point, Truth

NumbersT = TypeVar("NumbersT", float, npt.NDArray[np.float64])
"""A number, or an array of them."""
NAMES = ("x1", "x2")
"""The coordinates."""


def proposed(lab: Optimization, truth: Truth, point: Point) -> float:
    """The loss that the simulator gives for a proposal."""
    lab.restore(truth)
    lab.step(point)
    return lab.truth.y


def succeeds(lab: Optimization, truth: Truth, point: Point) -> bool:
    """Whether a proposal solves the task."""
    lab.restore(truth)
    return bool(lab.step(point)[4]["success"])


def takes(lab: Optimization, truth: Truth, point: Point, before: float, after: float) -> bool:
    """Whether a proposal takes the loss from `before` to `after`."""
    return proposed(lab, truth, truth.x) == before and proposed(lab, truth, point) == after


def contains(lab: Optimization, point: Point) -> bool:
    """Whether a point is in the domain."""
    return all(low <= x <= high for low, x, high in zip(lab.lows, point, lab.highs, strict=True))


def write(point: Point) -> str:
    """A point as text."""
    return f"[{point[0]!r}, {point[1]!r}]"


def directions(x: Point, point: Point) -> str:
    """The directions from one point to another, in words."""
    (a1, a2), (b1, b2) = x, point
    way1 = "raise" if b1 > a1 else "lower" if b1 < a1 else "leave"
    way2 = "raise" if b2 > a2 else "lower" if b2 < a2 else "leave"
    return f"{way1} x1 and {way2} x2"


def with_coordinate(x: Point, i: int, value: float) -> Point:
    """The point with another value of one coordinate."""
    return (x[0], value) if i else (value, x[1])


def between(a: tuple[NumbersT, NumbersT], b: tuple[NumbersT, NumbersT], share: float) -> tuple[NumbersT, NumbersT]:
    """The point that lies this share of the way from `a` to `b`; of arrays, one for each of their points."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def moved_inside(lab: Optimization, point: Point) -> Point:
    """The point with six significant digits, moved into the domain."""
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    x1, x2 = six_digits(point[0]) + 0.0, six_digits(point[1]) + 0.0  # without a negative zero
    if low1 <= x1 <= high1 and low2 <= x2 <= high2:
        return x1, x2
    x1, x2 = low1 if x1 < low1 else min(x1, high1), low2 if x2 < low2 else min(x2, high2)
    return x1 + 0.0, x2 + 0.0


def six_digits(x: float) -> float:
    """`float(f"{x:.6g}")`, most often in half its time."""
    if 1.0 <= abs(x) < 100.0:
        scale = 1e5 if abs(x) < 10.0 else 1e4
        scaled = x * scale
        whole = round(scaled)
        if abs(scaled - whole) < 0.49:  # else the product may have been rounded across the half
            return whole / scale
    return float(f"{x:.6g}")


def corners_of(lab: Optimization) -> tuple[Point, ...]:
    """The corners of the domain, the lowest first and the highest last."""
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    return (low1, low2), (low1, high2), (high1, low2), (high1, high2)


def grid(lab: Optimization) -> Iterator[Point]:
    """Points all over the domain, its corners included."""
    low, high = corners_of(lab)[0], corners_of(lab)[-1]
    for i in range(_SIDE):
        for j in range(_SIDE):
            x1, x2 = between(low, high, i / (_SIDE - 1))[0], between(low, high, j / (_SIDE - 1))[1]
            yield min(x1, high[0]), min(x2, high[1])


def minimiser_of(lab: Optimization, truth: Truth) -> Point:
    """A point of least loss."""
    return Landscape(lab.loss, truth.shift).minimisers()[0]


_SIDE = 9
