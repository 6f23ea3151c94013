"""Paths into the spot in the order of their costs, by branch and bound.

There is a lower bound of the cost of a path before its word is computed: with the turning radius as unit, a path of
length L leads no farther than L, and less far if it begins or ends in another direction. So only words that may cost
less than those before them are computed.
"""

from math import atan2, ceil, cos, inf, pi, sin, sqrt
from typing import NamedTuple

from teachers.oracles.parking.model import HALF, STEPS, Car, Ground, has_room
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
from worlds.parking import DT

SPACING = 0.5
"""Distance between the points of a path, in m."""
TOP = 5.0
"""Greatest speed of pursuit, in m/s."""
Start = tuple[int, Car]
"""Start of a path: the number of actions before it, and the car."""
End = tuple[float, float]
"""End of a path: its distance before the middle of the spot, and the length of its last straight line, in m."""
_TURN, _QUARTER = 2 * pi, pi / 2
_RADIUS = 5.6  # of planned arcs, in m; the car's least one is 5
_CUSP = 4.0  # estimated cost of a change of direction, in m
_TINY = 1e-6  # shorter pieces are ignored
_ROOM = 0.3  # distance of a path from obstacles, in m
_ROUNDING = 1e-4  # margin of the bounds, in m
_CUSPS = (0, 0, 1, 1, 2)  # changes of direction in words of each kind
_SIDES = tuple([tuple(["R L".index(piece) - 1 if piece in "RL" else 0 for piece in f"{word:5}S"]) for word in PIECES])


class Segment(NamedTuple):
    """A part of a path that is driven in one direction."""

    way: int
    """1 forwards, -1 backwards."""
    xs: list[float]
    ys: list[float]
    """The points, for the rear axle."""
    headings: list[float]


class Path(NamedTuple):
    """A path to the spot."""

    cost: float
    """Estimated cost, in m."""
    number: int
    """Index among all paths."""
    start: int
    """Index of its start."""
    word: int
    """Index of its word in `PIECES`."""
    lengths: tuple[float, float, float, float, float, float]
    """Of the word's pieces and of the straight line at its end, in turning radii; negative if driven backwards."""


class Target(NamedTuple):
    """A pose of the rear axle at the end of a path, relative to its start."""

    number: int
    start: int
    pose: tuple[float, float, float, float, float]
    """x and y in turning radii, heading, and the heading's sine and cosine."""
    speed: float
    """Of the car at the start, in m/s."""
    base: float
    """Cost of the path besides its pieces, in m."""
    straight: float
    """The straight line at its end, in m."""


def targets(ground: Ground, starts: list[Start], ends: tuple[End, ...]) -> list[Target]:
    """The targets of paths from these starts; every other end only for starts after actions."""
    goal_x, goal_y, goal = ground.spot
    goal_cos, goal_sin = cos(goal), sin(goal)
    found: list[Target] = []
    number = 0
    for index in range(len(starts)):
        before, (x, y, heading, speed) = starts[index]
        cosine, sine = cos(heading), sin(heading)
        rear_x, rear_y, turn = x - HALF * cosine, y - HALF * sine, wrapped(goal - heading)
        turn_sin, turn_cos, led = sin(turn), cos(turn), before * DT * STEPS * TOP
        for place in range(0, len(ends), 2 if before else 1):
            short, straight = ends[place]
            behind = HALF + short + straight
            dx = (goal_x - behind * goal_cos - rear_x) / _RADIUS
            dy = (goal_y - behind * goal_sin - rear_y) / _RADIUS
            pose = cosine * dx + sine * dy, cosine * dy - sine * dx, turn, turn_sin, turn_cos
            found.append(Target(number, index, pose, speed, short + led, straight))
            number += 1
    return found


def cheapest(targets: list[Target]) -> list[Path]:
    """The first of all paths by cost and number, as a list; empty if there is none."""
    found: list[Path] = []
    most = inf
    for target in targets:
        for kind, bound in enumerate(_bounds(target, most)):
            if bound <= most:
                for word in _words(kind, target, most):
                    path = _path(target, word)
                    if not found:
                        found.append(path)
                    elif (path.cost, path.number) < (found[0].cost, found[0].number):
                        found[0] = path
                    most = found[0].cost + _ROUNDING
    return found


def paths(targets: list[Target], most: float) -> list[Path]:
    """All paths with at most this cost, in the same order."""
    found: list[Path] = []
    for target in targets:
        for kind in range(len(_CUSPS)):
            for word in _words(kind, target, most + _ROUNDING):
                path = _path(target, word)
                if path.cost <= most:
                    found.append(path)
    return sorted(found)


def _words(kind: int, target: Target, most: float) -> list[Word]:
    """Words of a kind to a target, for paths with at most this cost."""
    x, y, turn, sine, cosine = target.pose
    left = (most - target.base - target.straight - _CUSPS[kind] * _CUSP) / _RADIUS
    if kind == 0:
        return forwards(x, y, turn, sine, cosine, left)
    if kind == 1:
        return backwards(x, y, turn, sine, cosine, left)
    if kind == 2:
        return one_cusp(x, y, turn, sine, cosine, left)
    if kind == 3:
        return nearby(x, y, turn, sine, cosine, left)
    return two_cusps(x, y, turn, sine, cosine, left)


def _path(target: Target, word: Word) -> Path:
    number, (a, b, c, d, e) = word
    lengths = a, b, c, d, e, target.straight / _RADIUS
    return Path(_cost(target, lengths), target.number * len(PIECES) + number, target.start, number, lengths)


def _cost(target: Target, lengths: tuple[float, float, float, float, float, float]) -> float:
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


def _reversal(speed: float) -> float:
    """Cost of a start against the speed, in m."""
    return speed * speed / 5 + abs(speed)


def _bounds(target: Target, most: float) -> tuple[float, float, float, float, float]:
    """Lower bounds of the costs of words of each kind; infinite if they exceed `most`.

    On a path of length L, in turning radii, the angle between the car and the direction of the target is at least
    begin - s after s, and end - s when s is left, since it changes by at most 1 per length. So the distance covered is
    at most the integral of the cosine of these, which is L minus begin - sin(begin) + end - sin(end). A near target may
    be reached before these turns are complete, but not sooner than straight on. Backwards the angles are those of the
    car's back.
    """
    _, _, (x, y, turn, _, _), speed, base, straight = target
    base += straight
    distance = sqrt(x * x + y * y)
    ahead = back = either = distance
    if base + distance * _RADIUS > most:
        return inf, inf, inf, inf, inf
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


def trace(ground: Ground, car: Car, path: Path) -> list[Segment]:
    """The segments of a path; empty if it comes too close to an obstacle."""
    x, y, heading, _ = car
    cosine, sine = cos(heading), sin(heading)
    x, y = x - HALF * cosine, y - HALF * sine
    segments: list[Segment] = []
    for number in range(len(path.lengths)):
        length, side = path.lengths[number], _SIDES[path.word][number]
        if abs(length) < _TINY:
            continue
        way = 1 if length > 0 else -1
        if not segments or segments[-1].way != way:
            segments.append(Segment(way, [x], [y], [heading]))
        run = abs(length) * _RADIUS
        steps = ceil(run / SPACING)
        counted = range(1, steps + 1)
        if side:
            bend, radius = side * length / steps, side * _RADIUS
            middle_x, middle_y = x - radius * sine, y + radius * cosine
            headings = [heading + bend * step for step in counted]
            xs = [middle_x + radius * sin(each) for each in headings]
            ys = [middle_y - radius * cos(each) for each in headings]
        else:
            step_x, step_y = length * _RADIUS / steps * cosine, length * _RADIUS / steps * sine
            xs, ys = [x + step_x * step for step in counted], [y + step_y * step for step in counted]
            headings = [heading] * steps
        if not has_room(ground, xs, ys, headings, run, _ROOM):
            segments.clear()
            return segments
        last = segments[-1]
        last.xs.extend(xs)
        last.ys.extend(ys)
        last.headings.extend(headings)
        x, y, heading = xs[-1], ys[-1], headings[-1]
        cosine, sine = cos(heading), sin(heading)
    return segments
