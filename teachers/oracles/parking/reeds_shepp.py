"""The shortest ways of a car that goes forwards and backwards and cannot turn tighter than its turning circle.

J. A. Reeds and L. A. Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific Journal of
Mathematics 145 (1990). A path is a word of at most five pieces, each a left arc, a right arc or a straight line; every
word is one of eight formulas, mirrored, reversed in time or read from its end. Lengths are in turning radii; "left"
is where headings grow.
"""

from collections.abc import Callable, Iterator, Sequence
from itertools import count, product
from math import acos, asin, atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

_TURN = 2 * pi
_QUARTER = pi / 2
_TINY = 1e-9
_Lengths = tuple[float, ...] | None


Word = tuple[int, str, tuple[float, ...]]
"""A path: its place among all words, its pieces, each L, R or S, and their lengths, negative if driven backwards."""
View = tuple[float, float, float, float, float]
"""A point, a heading, and the heading's sine and cosine: what formulas are given."""


class Shape(NamedTuple):
    """A formula and the symmetry that is applied to it."""

    number: int
    formula: Callable[[float, float, float, float, float, float], _Lengths]
    pieces: str
    """Of the word that it gives."""
    view: int
    """Which of the `views` the formula is given."""
    time: int
    """-1 if the way is reversed in time."""
    back: bool
    """Whether it is read from its end."""


def views(x: float, y: float, turn: float) -> list[View]:
    """A point and heading as they are seen by each symmetry: back or not, reversed in time or not, mirrored or not.

    Args:
        x, y: the point, in turning radii, from an origin where one looks along the x axis.
        turn: the heading there, in radians.
    """
    sine, cosine = sin(turn), cos(turn)
    back_x, back_y = x * cosine + y * sine, x * sine - y * cosine
    return [
        (x, y, turn, sine, cosine),
        (x, -y, -turn, -sine, cosine),
        (-x, y, -turn, -sine, cosine),
        (-x, -y, turn, sine, cosine),
        (back_x, back_y, turn, sine, cosine),
        (back_x, -back_y, -turn, -sine, cosine),
        (-back_x, back_y, -turn, -sine, cosine),
        (-back_x, -back_y, turn, sine, cosine),
    ]


def words(seen: Sequence[View], shapes: Sequence[Shape], most: float = inf) -> list[Word]:
    """The words that lead from the origin, looking along the x axis, to a point and heading.

    Args:
        seen: the `views` of the point and heading.
        shapes: which words.
        most: words of a greater length may be left out.
    """
    found = []
    for number, formula, pieces, view, time, back in shapes:
        lengths = formula(*seen[view], most)
        if lengths is not None:
            if time == -1:
                lengths = tuple([-each for each in lengths])
            found.append((number, pieces, lengths[::-1] if back else lengths))
    return found


def wrapped(angle: float) -> float:
    """The angle from -pi to pi."""
    return (angle + pi) % _TURN - pi


# Each formula is given a view and the most that the lengths may come to; it gives None where there is no such word,
# perhaps also where it would be longer.


def _lsl(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x - sine, y - 1 + cosine
    first, straight = atan2(y, x), hypot(x, y)
    if first < -_TINY or first + straight > most:
        return None
    last = (turn - first + pi) % _TURN - pi
    return (first, straight, last) if last >= -_TINY else None


def _lsr(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x + sine, y - 1 - cosine
    square = x * x + y * y - 4
    if square < 0:
        return None
    straight = sqrt(square)
    first = (atan2(y, x) + atan2(2, straight) + pi) % _TURN - pi
    if first < -_TINY or first + straight > most:
        return None
    last = (first - turn + pi) % _TURN - pi
    return (first, straight, last) if last >= -_TINY else None


def _lrl(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x - sine, y - 1 + cosine
    distance = hypot(x, y)
    if distance > 4:
        return None
    middle = -2 * asin(distance / 4)
    first = (atan2(y, x) + middle / 2 + pi + pi) % _TURN - pi
    if first < -_TINY or first - middle > most:
        return None
    return first, middle, wrapped(turn - first + middle)


def _ends(u: float, v: float, x: float, y: float, turn: float) -> tuple[float, float]:
    """The outer arcs of a path of four arcs."""
    delta = wrapped(u - v)
    a, b = sin(u) - sin(delta), cos(u) - cos(delta) - 1
    first = atan2(y * a - x * b, x * a + y * b)
    if 2 * (cos(delta) - cos(v) - cos(u)) + 3 < 0:
        first += pi
    first = wrapped(first)
    return first, wrapped(first - u + v - turn)


def _lrlr_cusp_last(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x + sine, y - 1 - cosine
    share = (2 + hypot(x, y)) / 4
    if share > 1:
        return None
    u = acos(share)
    if 2 * u > most:
        return None
    first, last = _ends(u, -u, x, y, turn)
    return (first, u, -u, last) if first >= -_TINY and last <= _TINY else None


def _lrlr_cusps_outside(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x + sine, y - 1 - cosine
    share = (20 - x * x - y * y) / 16
    if not 0 <= share <= 1:
        return None
    u = -acos(share)
    if -2 * u > most:
        return None
    first, last = _ends(u, u, x, y, turn)
    return (first, u, u, last) if first >= -_TINY and last >= -_TINY else None


def _lrsl(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x - sine, y - 1 + cosine
    square = x * x + y * y - 4
    if square < 4:
        return None
    root = sqrt(square)
    first = (atan2(y, x) + atan2(root, -2) + pi) % _TURN - pi
    if first < -_TINY or first + _QUARTER + root - 2 > most:
        return None
    last = (turn - _QUARTER - first + pi) % _TURN - pi
    return (first, -_QUARTER, 2 - root, last) if last <= _TINY else None


def _lrsr(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x + sine, y - 1 - cosine
    distance, first = hypot(x, y), atan2(x, -y)
    if distance < 2 or first < -_TINY or first + _QUARTER + distance - 2 > most:
        return None
    last = (first + _QUARTER - turn + pi) % _TURN - pi
    return (first, -_QUARTER, 2 - distance, last) if last <= _TINY else None


def _lrslr(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> _Lengths:
    x, y = x + sine, y - 1 - cosine
    square = x * x + y * y - 4
    if square < 0:
        return None
    straight = 4 - sqrt(square)
    if straight > _TINY or -straight > most:
        return None
    first = wrapped(atan2((4 - straight) * x - 2 * y, -2 * x + (straight - 4) * y))
    last = wrapped(first - turn)
    return (first, -_QUARTER, straight, -_QUARTER, last) if first >= -_TINY and last >= -_TINY else None


def _shapes() -> Iterator[Shape]:
    """Every formula with its symmetries; those that are the same word again are left out."""
    number = count()
    for formula, pieces, two_ways in (
        (_lsl, "LSL", False),
        (_lsr, "LSR", False),
        (_lrl, "LRL", True),
        (_lrlr_cusp_last, "LRLR", False),
        (_lrlr_cusps_outside, "LRLR", False),
        (_lrsl, "LRSL", True),
        (_lrsr, "LRSR", True),
        (_lrslr, "LRSLR", False),
    ):
        mirrored = pieces.translate(str.maketrans("LR", "RL"))
        for back in (False, True) if two_ways else (False,):
            for view, (time, side) in enumerate(product((1, -1), (1, -1)), 4 * back):
                shape = pieces if side == 1 else mirrored
                yield Shape(next(number), formula, shape[::-1] if back else shape, view, time, back)


SHAPES = tuple(_shapes())
"""All of them, in the order of their numbers."""
FORWARDS = tuple(shape for shape in SHAPES if shape.formula in {_lsl, _lsr} and shape.time == 1)
"""Without a change of direction, forwards."""
BACKWARDS = tuple(shape for shape in SHAPES if shape.formula in {_lsl, _lsr} and shape.time == -1)
"""Without a change of direction, backwards."""
ONE_CUSP = tuple(shape for shape in SHAPES if shape.formula in {_lrsl, _lrsr})
"""With one change of direction and a quarter turn."""
TWO_CUSPS = tuple(shape for shape in SHAPES if shape.formula is _lrslr)
"""With two changes of direction and two quarter turns."""
NEARBY = tuple(shape for shape in SHAPES if shape.formula in {_lrl, _lrlr_cusp_last, _lrlr_cusps_outside})
"""Arcs alone, with a change of direction at least."""
NEAR = 6.5
"""Nothing that is farther away, in turning radii, is reached by those of `NEARBY`."""
