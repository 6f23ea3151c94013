"""Paths into the spot, the cheapest first, most of them without a look.

What a path costs at least is known before its words are: with the turning radius as unit, no way of length L leads
farther than L, and not even as far if it begins or ends across. So words are computed when it is their turn.
"""

from collections.abc import Iterator, Sequence
from itertools import accumulate, repeat
from math import atan2, ceil, cos, hypot, inf, pi, sin
from typing import NamedTuple

from teachers.oracles.parking.model import DT, HALF, STEPS, Car, Ground, Hundredths, has_room
from teachers.oracles.parking.reeds_shepp import (
    BACKWARDS,
    FORWARDS,
    NEAR,
    NEARBY,
    ONE_CUSP,
    SHAPES,
    TWO_CUSPS,
    Shape,
    View,
    Word,
    views,
    words,
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
_TURN = 2 * pi
_RADIUS = 5.6  # of planned arcs, in m; the car's own is 5
_CUSP = 4.0  # m that a change of direction is thought to cost
_TINY = 1e-6  # shorter pieces count for nothing
_ROOM = 0.3  # m that a path keeps from everything
_ROUNDING = 1e-6  # m by which the bounds are lowered


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
    lengths: tuple[float, ...]
    """As of a `Word`, in turning radii."""


class _Target(NamedTuple):
    """Where a path may lead the rear axle, as seen from where it begins."""

    number: int
    start: int
    x: float
    y: float
    """In turning radii."""
    turn: float
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
    rest = [_path(target, word) for target in targets for word in words(views(*target[2:5]), SHAPES)]
    yield from sorted(rest)[1:]


def _first(targets: Sequence[_Target]) -> Path | None:
    """The first of all paths, if there is one."""
    seen: dict[int, list[View]] = {}
    first, most = None, inf
    for bound, number, cusps, shapes in sorted([each for target in targets for each in _bounds(target)]):
        if bound > most:
            break
        target = targets[number]
        if number not in seen:
            seen[number] = views(*target[2:5])
        for word in words(seen[number], shapes, (most - target.base - cusps * _CUSP) / _RADIUS):
            if first is None or _cost(target, word[2]) <= first.cost:
                path = _path(target, word)
                if first is None or path < first:
                    first, most = path, path.cost + _ROUNDING
    return first


def _path(target: _Target, word: Word) -> Path:
    number, pieces, lengths = word
    cost = _cost(target, lengths)
    if target.straight:
        pieces, lengths = pieces + "S", (*lengths, target.straight / _RADIUS)
    return Path(cost, target.number * len(SHAPES) + number, target.start, pieces, lengths)


def _cost(target: _Target, lengths: Sequence[float]) -> float:
    """The estimated cost of a path whose words have these lengths."""
    cost, way, speed = target.base, 0.0, target.speed
    if target.straight:
        lengths = (*lengths, target.straight / _RADIUS)
    for length in lengths:
        if abs(length) > _TINY:
            cost += abs(length) * _RADIUS
            if way * length < 0:
                cost += _CUSP
            elif not way and speed * length < 0:
                cost += _reversal(speed)
            way = length
    return cost


def _targets(ground: Ground, starts: Sequence[Start], ends: Sequence[End]) -> Iterator[_Target]:
    goal_x, goal_y, goal = ground.spot
    goal_cos, goal_sin = cos(goal), sin(goal)
    number = 0
    for index, (before, (x, y, heading, speed)) in enumerate(starts):
        cosine, sine = cos(heading), sin(heading)
        rear_x, rear_y, turn = x - HALF * cosine, y - HALF * sine, wrapped(goal - heading)
        for short, straight in ends if not before else ends[::2]:
            dx = (goal_x - (HALF + short + straight) * goal_cos - rear_x) / _RADIUS
            dy = (goal_y - (HALF + short + straight) * goal_sin - rear_y) / _RADIUS
            base = short + len(before) * DT * STEPS * TOP
            there_x, there_y = cosine * dx + sine * dy, cosine * dy - sine * dx
            yield _Target(number, index, there_x, there_y, turn, speed, base, straight)
            number += 1


def _reversal(speed: float) -> float:
    """What it costs to begin against the speed."""
    return speed * speed / 5 + abs(speed)


def _bounds(target: _Target) -> list[tuple[float, int, int, tuple[Shape, ...]]]:
    """What words of some shapes cost at least; with the target's number and the cusps that they have at least.

    On a way of length L, in turning radii, that leads into some direction, the car is off that direction by at least
    begin - s after s, and by end - s when s is left: it turns by 1 per length at most. So it gets no farther than the
    integral of the cosine of these, which is L less begin - sin(begin) + end - sin(end). What is near may be reached
    before these turns are complete, but not sooner than straight on. Backwards the angles are those of the car's back.
    """
    number, _, x, y, turn, speed, base, straight = target
    distance, begin = hypot(x, y), atan2(y, x)
    end = abs((turn - begin + pi) % _TURN - pi)
    begin = abs(begin)
    back_begin, back_end = pi - begin, pi - end
    gained = sin(begin) + sin(end)
    far = distance > gained
    base += straight
    forwards = base + _RADIUS * (distance + (begin + end - gained if far else 0))
    backwards = base + _RADIUS * (distance + (back_begin + back_end - gained if far else 0))
    if speed < 0:
        forwards += _reversal(speed)
    else:
        backwards += _reversal(speed)
    either = distance + (min(begin, back_begin) + min(end, back_end) - gained if far else 0)
    bounds = [
        (forwards, number, 0, FORWARDS),
        (backwards, number, 0, BACKWARDS),
        (base + _CUSP + _RADIUS * max(either, pi / 2), number, 1, ONE_CUSP),
        (base + 2 * _CUSP + _RADIUS * max(either, pi), number, 2, TWO_CUSPS),
    ]
    if distance <= NEAR:
        bounds.append((base + _CUSP + _RADIUS * either, number, 1, NEARBY))
    return bounds


def trace(ground: Ground, car: Car, path: Path) -> list[Segment] | None:
    """The points of a path, or None if it comes too close to something."""
    x, y, heading, _ = car
    x, y = x - HALF * cos(heading), y - HALF * sin(heading)
    segments: list[Segment] = []
    for piece, length in zip(path.pieces, path.lengths, strict=True):
        if abs(length) < _TINY:
            continue
        count = ceil(abs(length) * _RADIUS / SPACING)
        step = length * _RADIUS / count
        bend = 0.0 if piece == "S" else step / _RADIUS if piece == "L" else -step / _RADIUS
        headings = list(accumulate(repeat(bend, count), initial=heading))
        if bend:
            chord = step * sin(bend / 2) / (bend / 2)
            courses = [each + bend / 2 for each in headings[:-1]]
            dxs, dys = [chord * cos(course) for course in courses], [chord * sin(course) for course in courses]
        else:
            dxs, dys = [step * cos(heading)] * count, [step * sin(heading)] * count
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
