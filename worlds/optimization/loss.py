"""Losses: functions of two numbers on a rectangle, with their derivatives, and shifts of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

Point = tuple[float, float]
Value = Callable[[float, float], float]
Gradient = Callable[[float, float], Sequence[float]]


@dataclass(frozen=True)
class Loss:
    """A loss on a rectangle, with its derivatives and minimisers."""

    value: Value
    gradient: Gradient
    """The two first derivatives."""
    hessian: Gradient
    """The second derivatives: by x1 twice, by both, by x2 twice."""
    lows: Point
    highs: Point
    minimisers: tuple[Point, ...]
    """The points of the rectangle with the least loss."""

    @property
    def minimum(self) -> float:
        """The least loss on the rectangle."""
        return min(self.value(*point) for point in self.minimisers)

    @property
    def corner(self) -> float:
        """The largest loss at a corner of the rectangle; rewards do not fall below its negative."""
        return max(self.value(*corner) for corner in product(*zip(self.lows, self.highs, strict=True)))


class Landscape:
    """A loss that is shifted within its rectangle.

    Its value at `x` is the loss at `x - shift`, reflected at the edge where that lies outside the rectangle: range and
    minimum stay the same, and the loss is evaluated in its domain only.
    """

    value: Value
    """The loss."""
    gradient: Gradient
    """The two first derivatives; at a reflecting edge, those of one of its sides."""
    hessian: Gradient
    """The second derivatives: by x1 twice, by both, by x2 twice."""

    def __init__(self, loss: Loss, shift: Point) -> None:
        self.loss, self.shift = loss, shift
        if shift == (0.0, 0.0):
            self.value, self.gradient, self.hessian = loss.value, loss.gradient, loss.hessian
        else:
            self.value, self.gradient, self.hessian = self._value, self._gradient, self._hessian

    def minimisers(self) -> tuple[Point, ...]:
        """The points with the least loss, mirror images included."""
        return tuple(
            dict.fromkeys(p for m in self.loss.minimisers for p in product(self._images(0, m), self._images(1, m)))
        )

    def _value(self, x1: float, x2: float) -> float:
        (z1, _), (z2, _) = self._place(0, x1), self._place(1, x2)
        return self.loss.value(z1, z2)

    def _gradient(self, x1: float, x2: float) -> tuple[float, float]:
        (z1, sign1), (z2, sign2) = self._place(0, x1), self._place(1, x2)
        g1, g2 = self.loss.gradient(z1, z2)
        return sign1 * g1, sign2 * g2

    def _hessian(self, x1: float, x2: float) -> tuple[float, float, float]:
        (z1, sign1), (z2, sign2) = self._place(0, x1), self._place(1, x2)
        h11, h12, h22 = self.loss.hessian(z1, z2)
        return h11, sign1 * sign2 * h12, h22

    def _place(self, i: int, x: float) -> tuple[float, float]:
        """The unshifted coordinate, and -1 if it was reflected, else 1."""
        z, low, high = x - self.shift[i], self.loss.lows[i], self.loss.highs[i]
        if z < low:
            return 2 * low - z, -1.0
        return (2 * high - z, -1.0) if z > high else (z, 1.0)

    def _images(self, i: int, minimiser: Point) -> list[float]:
        """Shifted coordinates of a minimiser in the domain, mirror images included."""
        m, shift, low, high = minimiser[i], self.shift[i], self.loss.lows[i], self.loss.highs[i]
        return [x for x in (m + shift, 2 * low - m + shift, 2 * high - m + shift) if low <= x <= high]
