"""Shortest paths of a car that goes forwards and backwards with a least turning radius.

J. A. Reeds and L. A. Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific Journal of
Mathematics 145 (1990). A path is a word of at most five pieces, each a left arc, a right arc or a straight line; every
word follows one of eight formulas, possibly mirrored, reversed in time or read from its end. Lengths are in turning
radii; left is the direction of increasing headings.
"""

from collections.abc import Iterator
from itertools import product
from math import acos, asin, atan2, cos, inf, pi, sin, sqrt

_TURN = 2 * pi
_QUARTER = pi / 2
_TINY = 1e-9
_SLACK = 1e-8  # for angles that are 0 but for rounding
_BELOW = -1e-6  # below it the first arc is negative, for targets less than a thousand radii away

Lengths = tuple[float, float, float, float, float]
"""Lengths of the pieces of a word, negative if driven backwards; 0 for missing pieces."""
Word = tuple[int, Lengths]
"""A path: its index in `PIECES`, and the lengths of its pieces."""


def _pieces() -> Iterator[str]:
    for pieces, two_ways in (
        ("LSL", False),
        ("LSR", False),
        ("LRL", True),
        ("LRLR", False),
        ("LRLR", False),
        ("LRSL", True),
        ("LRSR", True),
        ("LRSLR", False),
    ):
        mirrored = pieces.translate(str.maketrans("LR", "RL"))
        for back, _, shape in product((False, True)[: 1 + two_ways], (1, -1), (pieces, mirrored)):
            yield shape[::-1] if back else shape


PIECES = tuple(_pieces())
"""The pieces of every word, each L, R or S: by formula, read from its end, reversed in time, mirrored."""
_EITHER_WAY = ((0, 1.0), (2, -1.0))  # what reversal in time adds to the number, and the sign of lengths


# Each of these functions returns words from the origin, with heading 0, to a point and heading, except those that are
# longer than `most`. In the loops (p, q) is the vector from the middle of the first circle to that of the last, for a
# word that begins with an arc to the left: mirrored words have other circles, and words reversed in time have the same
# circles with p negated, so that they share a distance. The headings give the length of all arcs together, or a lower
# bound, before the single arcs are computed.


def forwards(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> list[Word]:
    """An arc, a line and an arc."""
    return _in_one_direction(x, y, turn, sine, cosine, most, 1.0)


def backwards(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> list[Word]:
    """The same backwards."""
    return _in_one_direction(x, y, turn, sine, cosine, most, -1.0)


def _in_one_direction(
    x: float, y: float, turn: float, sine: float, cosine: float, most: float, way: float
) -> list[Word]:
    found: list[Word] = []
    after = 2 if way < 0 else 0
    x, turn, sine = way * x, way * turn, way * sine
    for number, p, q, bend in ((0, x - sine, y - 1 + cosine, turn), (1, x + sine, -y - 1 + cosine, -turn)):
        if q >= _BELOW:
            straight = sqrt(p * p + q * q)
            if straight + (bend + _SLACK) % _TURN <= most:
                first = atan2(q, p)
                last = (bend - first + pi) % _TURN - pi
                if first >= -_TINY and last >= -_TINY:
                    found.append((number + after, (way * first, way * straight, way * last, 0.0, 0.0)))
    for number, p, q, bend in ((4, x + sine, y - 1 - cosine, turn), (5, x - sine, -y - 1 - cosine, -turn)):
        square = p * p + q * q - 4
        if square >= 0:
            straight = sqrt(square)
            if straight + abs((bend + pi) % _TURN - pi) <= most:
                first = (atan2(q, p) + atan2(2, straight) + pi) % _TURN - pi
                if first >= -_TINY:
                    last = (first - bend + pi) % _TURN - pi
                    if last >= -_TINY and first + straight + last <= most:
                        found.append((number + after, (way * first, way * straight, way * last, 0.0, 0.0)))
    return found


def one_cusp(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> list[Word]:
    """An arc, a quarter turn the other way, a line and an arc; or the same from the end."""
    found: list[Word] = []
    back_x, back_y = x * cosine + y * sine, x * sine - y * cosine
    for number, p, q, bend in (
        (24, x - sine, y - 1 + cosine, turn),
        (25, x + sine, -y - 1 + cosine, -turn),
        (28, back_x - sine, back_y - 1 + cosine, turn),
        (29, back_x + sine, -back_y - 1 + cosine, -turn),
    ):
        square = p * p + q * q - 4
        root = sqrt(square) if square >= 4 else inf
        if root + (_QUARTER - 2) <= most and root < inf:
            for after, way in _EITHER_WAY:
                left = (way * bend - _QUARTER + pi) % _TURN - pi
                if abs(left) + root + (_QUARTER - 2) <= most:
                    first = (atan2(q, way * p) + atan2(root, -2) + pi) % _TURN - pi
                    last = (way * bend - _QUARTER - first + pi) % _TURN - pi
                    if first >= -_TINY and last <= _TINY and first + _QUARTER + root - 2 - last <= most:
                        found.append(_word(number + after, number >= 28, way, first, -_QUARTER, 2 - root, last))
    for number, p, q, bend in (
        (32, x + sine, y - 1 - cosine, turn),
        (33, x - sine, -y - 1 - cosine, -turn),
        (36, back_x + sine, back_y - 1 - cosine, turn),
        (37, back_x - sine, -back_y - 1 - cosine, -turn),
    ):
        distance = sqrt(p * p + q * q)
        if distance >= 2 and distance + (_QUARTER - 2) <= most:
            for after, way in _EITHER_WAY:
                if way * p >= _BELOW and (way * bend - _QUARTER + _SLACK) % _TURN + distance + (_QUARTER - 2) <= most:
                    first = atan2(way * p, -q)
                    last = (first + _QUARTER - way * bend + pi) % _TURN - pi
                    if first >= -_TINY and last <= _TINY:
                        found.append(_word(number + after, number >= 36, way, first, -_QUARTER, 2 - distance, last))
    return found


def two_cusps(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> list[Word]:
    """An arc, a quarter turn the other way, a line, a quarter turn, and an arc the first way."""
    found: list[Word] = []
    for number, p, q, bend in ((40, x + sine, y - 1 - cosine, turn), (41, x - sine, -y - 1 - cosine, -turn)):
        square = p * p + q * q - 4
        straight = 4 - sqrt(square) if square >= 0 else inf
        if straight <= _TINY and pi - straight <= most:
            for after, way in _EITHER_WAY:
                first = wrapped(atan2((4 - straight) * way * p - 2 * q, -2 * way * p + (straight - 4) * q))
                last = wrapped(first - way * bend)
                if first >= -_TINY and last >= -_TINY and first + pi - straight + last <= most:
                    lengths = way * first, way * -_QUARTER, way * straight, way * -_QUARTER, way * last
                    found.append((number + after, lengths))
    return found


NEAR = 6.5
"""Greatest distance, in turning radii, of targets that words of `nearby` reach."""


def nearby(x: float, y: float, turn: float, sine: float, cosine: float, most: float) -> list[Word]:
    """Arcs only, with at least one change of direction."""
    found: list[Word] = []
    back_x, back_y = x * cosine + y * sine, x * sine - y * cosine
    for number, p, q, bend in (
        (8, x - sine, y - 1 + cosine, turn),
        (9, x + sine, -y - 1 + cosine, -turn),
        (12, back_x - sine, back_y - 1 + cosine, turn),
        (13, back_x + sine, -back_y - 1 + cosine, -turn),
    ):
        distance = sqrt(p * p + q * q)
        middle = 2 * asin(distance / 4) if distance <= 4 else inf
        if distance <= 4 and middle <= most:
            for after, way in _EITHER_WAY:
                around = (way * bend + _SLACK) % _TURN
                if around <= most or 2 * middle + _TURN - around <= most:
                    first = (atan2(q, way * p) - middle / 2 + pi + pi) % _TURN - pi
                    last = (way * bend - first - middle + pi) % _TURN - pi
                    if first >= -_TINY and first + middle + abs(last) <= most:
                        a, b = (last, first) if number >= 12 else (first, last)
                        found.append((number + after, (way * a, way * -middle, way * b, 0.0, 0.0)))
    for number, p, q, bend in ((16, x + sine, y - 1 - cosine, turn), (17, x - sine, -y - 1 - cosine, -turn)):
        distance = sqrt(p * p + q * q)
        if distance <= 2:
            u = acos((2 + distance) / 4)
            if 2 * u <= most:
                twice = wrapped(u + u)
                a, b = sin(u) - sin(twice), cos(u) - cos(twice) - 1
                for after, way in _EITHER_WAY:
                    if (way * bend + 2 * u + _SLACK) % _TURN + 2 * u <= most:
                        first = wrapped(atan2(q * a - way * p * b, way * p * a + q * b))
                        last = wrapped(first - u - u - way * bend)
                        if first >= -_TINY and last <= _TINY:
                            found.append((number + after, (way * first, way * u, way * -u, way * last, 0.0)))
        share = (20 - p * p - q * q) / 16
        if 0 <= share <= 1:
            u = -acos(share)
            if abs((bend + pi) % _TURN - pi) - 2 * u <= most:
                a, b = sin(u), cos(u) - 1 - 1
                for after, way in _EITHER_WAY:
                    first = wrapped(atan2(q * a - way * p * b, way * p * a + q * b))
                    last = wrapped(first - u + u - way * bend)
                    if first >= -_TINY and last >= -_TINY and first - 2 * u + last <= most:
                        found.append((number + 4 + after, (way * first, way * u, way * u, way * last, 0.0)))
    return found


def wrapped(angle: float) -> float:
    """The angle in the interval from -pi to pi."""
    return (angle + pi) % _TURN - pi


def _word(number: int, back: bool, way: float, a: float, b: float, c: float, d: float) -> Word:
    """A word of four pieces, possibly read from its end or reversed in time."""
    if back:
        return number, (way * d, way * c, way * b, way * a, 0.0)
    return number, (way * a, way * b, way * c, way * d, 0.0)
