"""The shortest ways of a car that goes forwards and backwards and cannot turn tighter than its turning circle.

J. A. Reeds and L. A. Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific Journal of
Mathematics 145 (1990). A path is a word of at most five pieces, each a left arc, a right arc or a straight line; every
word is one of eight formulas, mirrored, reversed in time or read from its end. Lengths are in turning radii; "left"
is where headings grow.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

_HALF_TURN = math.pi
_QUARTER = math.pi / 2
_TINY = 1e-9
_Lengths = tuple[float, ...] | None


class Word(NamedTuple):
    """A path."""

    pieces: str
    """The pieces, each L, R or S."""
    lengths: tuple[float, ...]
    """The length of each piece; negative if it is driven backwards."""


def words(x: float, y: float, turn: float) -> Iterator[Word]:
    """Every word that leads from the origin, looking along the x axis, to a point and heading.

    Args:
        x, y: where to, in turning radii.
        turn: the heading there, in radians.
    """
    cos, sin = math.cos(turn), math.sin(turn)
    back_x, back_y = x * cos + y * sin, x * sin - y * cos
    for formula, pieces, mirrored, two_ways in _FORMULAS:
        for there_x, there_y, order in ((x, y, 1), (back_x, back_y, -1)) if two_ways else ((x, y, 1),):
            for time in (1, -1):
                for side in (1, -1):
                    lengths = formula(time * there_x, side * there_y, time * side * turn)
                    if lengths is not None:
                        shape = pieces if side == 1 else mirrored
                        if time == -1:
                            lengths = tuple([-each for each in lengths])
                        yield Word(shape[::order], lengths[::order])


def wrapped(angle: float) -> float:
    """The angle from -pi to pi."""
    return (angle + _HALF_TURN) % (2 * _HALF_TURN) - _HALF_TURN


def _lsl(x: float, y: float, turn: float) -> _Lengths:
    x, y = x - math.sin(turn), y - 1 + math.cos(turn)
    first = math.atan2(y, x)
    last = wrapped(turn - first)
    return (first, math.hypot(x, y), last) if first >= -_TINY and last >= -_TINY else None


def _lsr(x: float, y: float, turn: float) -> _Lengths:
    x, y = x + math.sin(turn), y - 1 - math.cos(turn)
    square = x * x + y * y - 4
    if square < 0:
        return None
    straight = math.sqrt(square)
    first = wrapped(math.atan2(y, x) + math.atan2(2, straight))
    last = wrapped(first - turn)
    return (first, straight, last) if first >= -_TINY and last >= -_TINY else None


def _lrl(x: float, y: float, turn: float) -> _Lengths:
    x, y = x - math.sin(turn), y - 1 + math.cos(turn)
    distance = math.hypot(x, y)
    if distance > 4:
        return None
    middle = -2 * math.asin(distance / 4)
    first = wrapped(math.atan2(y, x) + middle / 2 + _HALF_TURN)
    return (first, middle, wrapped(turn - first + middle)) if first >= -_TINY else None


def _ends(u: float, v: float, x: float, y: float, turn: float) -> tuple[float, float]:
    """The outer arcs of a path of four arcs."""
    delta = wrapped(u - v)
    a, b = math.sin(u) - math.sin(delta), math.cos(u) - math.cos(delta) - 1
    first = math.atan2(y * a - x * b, x * a + y * b)
    if 2 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3 < 0:
        first += _HALF_TURN
    first = wrapped(first)
    return first, wrapped(first - u + v - turn)


def _lrlr_cusp_last(x: float, y: float, turn: float) -> _Lengths:
    x, y = x + math.sin(turn), y - 1 - math.cos(turn)
    cosine = (2 + math.hypot(x, y)) / 4
    if cosine > 1:
        return None
    u = math.acos(cosine)
    first, last = _ends(u, -u, x, y, turn)
    return (first, u, -u, last) if first >= -_TINY and last <= _TINY else None


def _lrlr_cusps_outside(x: float, y: float, turn: float) -> _Lengths:
    x, y = x + math.sin(turn), y - 1 - math.cos(turn)
    cosine = (20 - x * x - y * y) / 16
    if not 0 <= cosine <= 1:
        return None
    u = -math.acos(cosine)
    first, last = _ends(u, u, x, y, turn)
    return (first, u, u, last) if first >= -_TINY and last >= -_TINY else None


def _lrsl(x: float, y: float, turn: float) -> _Lengths:
    x, y = x - math.sin(turn), y - 1 + math.cos(turn)
    square = x * x + y * y - 4
    if square < 0:
        return None
    root = math.sqrt(square)
    first = wrapped(math.atan2(y, x) + math.atan2(root, -2))
    last = wrapped(turn - _QUARTER - first)
    return (first, -_QUARTER, 2 - root, last) if first >= -_TINY and root >= 2 and last <= _TINY else None


def _lrsr(x: float, y: float, turn: float) -> _Lengths:
    x, y = x + math.sin(turn), y - 1 - math.cos(turn)
    distance, first = math.hypot(x, y), math.atan2(x, -y)
    last = wrapped(first + _QUARTER - turn)
    return (first, -_QUARTER, 2 - distance, last) if distance >= 2 and first >= -_TINY and last <= _TINY else None


def _lrslr(x: float, y: float, turn: float) -> _Lengths:
    x, y = x + math.sin(turn), y - 1 - math.cos(turn)
    square = x * x + y * y - 4
    if square < 0:
        return None
    straight = 4 - math.sqrt(square)
    first = wrapped(math.atan2((4 - straight) * x - 2 * y, -2 * x + (straight - 4) * y))
    last = wrapped(first - turn)
    if straight > _TINY or first < -_TINY or last < -_TINY:
        return None
    return first, -_QUARTER, straight, -_QUARTER, last


_FORMULAS: tuple[tuple[Callable[[float, float, float], _Lengths], str, str, bool], ...] = tuple(
    (formula, pieces, pieces.translate(str.maketrans("LR", "RL")), two_ways)
    for formula, pieces, two_ways in (
        (_lsl, "LSL", False),
        (_lsr, "LSR", False),
        (_lrl, "LRL", True),
        (_lrlr_cusp_last, "LRLR", False),
        (_lrlr_cusps_outside, "LRLR", False),
        (_lrsl, "LRSL", True),
        (_lrsr, "LRSR", True),
        (_lrslr, "LRSLR", False),
    )
)
