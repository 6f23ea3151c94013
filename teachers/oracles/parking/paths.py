"""Paths into the spot, the cheapest first, most of them without a look.

What a path costs at least is known before its words are: with the turning radius as unit, no way of length L leads
farther than L, and not even as far if it begins or ends across. So only words that may be cheaper than those before
them are computed.
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate, count, repeat
from math import atan2, ceil, cos, hypot, inf, pi, sin
from typing import NamedTuple

from teachers.oracles.parking.model import DT, HALF, STEPS, Car, Ground, Hundredths, has_room
from teachers.oracles.parking.reeds_shepp import (
    NEAR,
    PIECES,
    Word,
    backwards,
    forwards,
    nearby,
    one_cusp,
    two_cusps,
    wrapped,
)

SPACING = 0.5
"""Between the points of a path, in m."""
TOP = 5.0
"""The fastest that the car is to go, in m/s."""
Start = tuple[tuple[Hundredths, ...], Car]
"""Where a path may begin, with the actions that lead there."""
End = tuple[float, float]
"""How far from the middle of the spot a path may end, since the car is parked before, and how straight it gets there,
in m."""
_TURN, _QUARTER = 2 * pi, pi / 2
_RADIUS = 5.6  # of planned arcs, in m; the car's own is 5
_CUSP = 4.0  # m that a change of direction is thought to cost
_TINY = 1e-6  # shorter pieces count for nothing
_ROOM = 0.3  # m that a path keeps from everything
_ROUNDING = 1e-4  # m by which the bounds are lowered
_DEARER = 8.0  # m by which a path that will do is seldom dearer than the first
_KINDS = ((forwards, 0), (backwards, 0), (one_cusp, 1), (nearby, 1), (two_cusps, 2))  # with the cusps that they have
_WHOLE = tuple([f"{pieces:5}S" for pieces in PIECES])  # with the straight line at the end


class Segment(NamedTuple):
    """A part of a path that is driven in one direction."""

    way: int
    """1 forwards, -1 backwards."""
    xs: list[float]
    ys: list[float]
    """The points, for the rear axle."""
    headings: list[float]


class Path(NamedTuple):
    """What leads to the spot."""

    cost: float
    """As estimated, in m."""
    number: int
    """Its place among all paths."""
    start: int
    """The number of the start where it begins."""
    pieces: str
    """Each L, R or S; a blank where there is none."""
    lengths: tuple[float, ...]
    """Of the pieces, in turning radii; negative if driven backwards."""


class _Target(NamedTuple):
    """Where a path may lead the rear axle, as seen from where it begins."""

    number: int
    start: int
    pose: tuple[float, float, float, float, float]
    """Its x and y in turning radii, its heading, and the sine and cosine of that."""
    speed: float
    """Of the car at the start, in m/s."""
    base: float
    """What the path costs besides its pieces, in m."""
    straight: float
    """The straight line at its end, in m."""


def cheapest(ground: Ground, starts: Sequence[Start], ends: Sequence[End]) -> Iterator[Path]:
    """Paths of the rear axle to the spot by their estimated cost; of those that cost the same, by their number."""
    targets = list(_targets(ground, starts, ends))
    first = _first(targets)
    if first is not None:
        yield first  # most often it will do
        known = 1
        for most in (first.cost + _DEARER, inf):
            found = sorted([path for target in targets for path in _paths(target, most)])
            yield from found[known:]
            known = len(found)


def _first(targets: Sequence[_Target]) -> Path | None:
    """The first of all paths, if there is one."""
    first, most = None, inf
    for target in targets:
        for (words, cusps), bound in zip(_KINDS, _bounds(target, most), strict=False):
            if bound <= most:
                for word in words(*target.pose, _left(target, cusps, most)):
                    path = _path(target, word)
                    if first is None or path < first:
                        first, most = path, path.cost + _ROUNDING
    return first


def _paths(target: _Target, most: float) -> list[Path]:
    """Those to a target that cost no more than that."""
    left = [words(*target.pose, _left(target, cusps, most + _ROUNDING)) for words, cusps in _KINDS]
    return [path for path in [_path(target, word) for found in left for word in found] if path.cost <= most]


def _left(target: _Target, cusps: int, most: float) -> float:
    """How long a word may be, in turning radii, for a path that is to cost no more than that."""
    return (most - target.base - target.straight - cusps * _CUSP) / _RADIUS


def _path(target: _Target, word: Word) -> Path:
    number, lengths = word
    whole = (*lengths, target.straight / _RADIUS)
    return Path(_cost(target, whole), target.number * len(PIECES) + number, target.start, _WHOLE[number], whole)


def _cost(target: _Target, lengths: Sequence[float]) -> float:
    """The estimated cost of a path whose pieces have these lengths."""
    cost, way, speed = target.base, 0.0, target.speed
    for length in lengths:
        size = length if length > 0 else -length
        if size > _TINY:
            cost += size * _RADIUS
            if way * length < 0:
                cost += _CUSP
            elif not way and speed * length < 0:
                cost += _reversal(speed)
            way = length
    return cost


def _targets(ground: Ground, starts: Sequence[Start], ends: Sequence[End]) -> Iterator[_Target]:
    goal_x, goal_y, goal = ground.spot
    goal_cos, goal_sin = cos(goal), sin(goal)
    number = count()
    for index, (before, (x, y, heading, speed)) in enumerate(starts):
        cosine, sine = cos(heading), sin(heading)
        rear_x, rear_y, turn = x - HALF * cosine, y - HALF * sine, wrapped(goal - heading)
        turn_sin, turn_cos, led = sin(turn), cos(turn), len(before) * DT * STEPS * TOP
        for short, straight in ends if not before else ends[::2]:
            behind = HALF + short + straight
            dx = (goal_x - behind * goal_cos - rear_x) / _RADIUS
            dy = (goal_y - behind * goal_sin - rear_y) / _RADIUS
            base = short + led
            pose = cosine * dx + sine * dy, cosine * dy - sine * dx, turn, turn_sin, turn_cos
            yield _Target(next(number), index, pose, speed, base, straight)


def _reversal(speed: float) -> float:
    """What it costs to begin against the speed."""
    return speed * speed / 5 + abs(speed)


def _bounds(target: _Target, most: float) -> tuple[float, ...]:
    """What words of each of `_KINDS` cost at least; nothing if they all cost more than `most`.

    On a way of length L, in turning radii, that leads into some direction, the car is off that direction by at least
    begin - s after s, and by end - s when s is left: it turns by 1 per length at most. So it gets no farther than the
    integral of the cosine of these, which is L less begin - sin(begin) + end - sin(end). What is near may be reached
    before these turns are complete, but not sooner than straight on. Backwards the angles are those of the car's back.
    """
    _, _, (x, y, turn, _, _), speed, base, straight = target
    base += straight
    distance = hypot(x, y)
    ahead = back = either = distance
    if base + distance * _RADIUS > most:
        return ()
    begin = atan2(y, x)
    end = abs((turn - begin + pi) % _TURN - pi)
    begin = abs(begin)
    gained = sin(begin) + sin(end)
    if distance > gained:
        ahead += begin + end - gained
        back += _TURN - begin - end - gained
        either += (begin if begin < _QUARTER else pi - begin) + (end if end < _QUARTER else pi - end) - gained
    ahead, back = base + _RADIUS * ahead, base + _RADIUS * back
    if speed < 0:
        ahead += _reversal(speed)
    elif speed:
        back += _reversal(speed)
    base += _CUSP
    return (
        ahead,
        back,
        base + _RADIUS * (either if either > _QUARTER else _QUARTER),
        base + _RADIUS * either if distance <= NEAR else inf,
        base + _CUSP + _RADIUS * (either if either > pi else pi),
    )


def trace(ground: Ground, car: Car, path: Path) -> list[Segment] | None:
    """The points of a path, or None if it comes too close to something."""
    x, y, heading, _ = car
    x, y = x - HALF * cos(heading), y - HALF * sin(heading)
    segments: list[Segment] = []
    for piece, length in zip(path.pieces, path.lengths, strict=True):
        if abs(length) < _TINY:
            continue
        steps = ceil(abs(length) * _RADIUS / SPACING)
        step = length * _RADIUS / steps
        bend = 0.0 if piece == "S" else step / _RADIUS if piece == "L" else -step / _RADIUS
        headings = list(accumulate(repeat(bend, steps), initial=heading))
        if bend:
            chord = step * sin(bend / 2) / (bend / 2)
            courses = [each + bend / 2 for each in headings[:-1]]
            dxs, dys = [chord * cos(course) for course in courses], [chord * sin(course) for course in courses]
        else:
            dxs, dys = [step * cos(heading)] * steps, [step * sin(heading)] * steps
        xs, ys = list(accumulate(dxs, initial=x)), list(accumulate(dys, initial=y))
        x, y, heading = xs[-1], ys[-1], headings[-1]
        if not has_room(ground, xs[1:], ys[1:], headings[1:], _ROOM):
            return None
        way = 1 if length > 0 else -1
        if segments and segments[-1].way == way:
            for points, more in zip(segments[-1][1:], (xs, ys, headings), strict=True):
                points += more[1:]
        else:
            segments.append(Segment(way, xs, ys, headings))
    return segments
