"""Paths into the spot, the cheapest first, most of them without a look.

What a path costs at least is known before its words are: with the turning radius as unit, no way of length L leads
farther than L, and not even as far if it begins or ends across. So only words that may be cheaper than those before
them are computed.
"""

from math import atan2, ceil, cos, inf, pi, sin, sqrt
from typing import NamedTuple

from teachers.compiled import compiled
from teachers.oracles.parking.model import DT, HALF, STEPS, Car, Ground, has_room
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
Start = tuple[int, Car]
"""Where a path may begin, after so many actions."""
End = tuple[float, float]
"""How far from the middle of the spot a path may end, since the car is parked before, and how straight it gets there,
in m."""
_TURN, _QUARTER = 2 * pi, pi / 2
_RADIUS = 5.6  # of planned arcs, in m; the car's own is 5
_CUSP = 4.0  # m that a change of direction is thought to cost
_TINY = 1e-6  # shorter pieces count for nothing
_ROOM = 0.3  # m that a path keeps from everything
_ROUNDING = 1e-4  # m by which the bounds are lowered
_CUSPS = (0, 0, 1, 1, 2)  # that words of each kind have
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
    """What leads to the spot."""

    cost: float
    """As estimated, in m."""
    number: int
    """Its place among all paths."""
    start: int
    """The number of the start where it begins."""
    word: int
    """The place of its word among all words."""
    lengths: tuple[float, float, float, float, float, float]
    """Of the word's pieces and of the straight line at its end, in turning radii; negative if driven backwards."""


class Target(NamedTuple):
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


@compiled
def targets(ground: Ground, starts: list[Start], ends: tuple[End, ...]) -> list[Target]:
    """Where paths from these starts may lead; only to every other end if actions come before."""
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


@compiled
def cheapest(targets: list[Target]) -> list[Path]:
    """The first of all paths by their cost, and by their number; nothing if there is none."""
    found: list[Path] = []
    most = inf
    for target in targets:
        for kind, bound in enumerate(_bounds(target, most)):
            if bound <= most:
                for word in _words(kind, target, most):
                    path = _path(target, word)
                    if not found:
                        found.append(path)
                    elif path < found[0]:
                        found[0] = path
                    most = found[0].cost + _ROUNDING
    return found


@compiled
def paths(targets: list[Target], most: float) -> list[Path]:
    """All that cost no more than that, in the same order."""
    found: list[Path] = []
    for target in targets:
        for kind in range(len(_CUSPS)):
            for word in _words(kind, target, most + _ROUNDING):
                path = _path(target, word)
                if path.cost <= most:
                    found.append(path)
    return sorted(found)


@compiled
def _words(kind: int, target: Target, most: float) -> list[Word]:
    """Words of a kind to a target, for paths that are to cost no more than that."""
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


@compiled
def _path(target: Target, word: Word) -> Path:
    number, (a, b, c, d, e) = word
    lengths = a, b, c, d, e, target.straight / _RADIUS
    return Path(_cost(target, lengths), target.number * len(PIECES) + number, target.start, number, lengths)


@compiled
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


@compiled
def _reversal(speed: float) -> float:
    """What it costs to begin against the speed."""
    return speed * speed / 5 + abs(speed)


@compiled
def _bounds(target: Target, most: float) -> tuple[float, float, float, float, float]:
    """What words of each kind cost at least; infinite if they all cost more than `most`.

    On a way of length L, in turning radii, that leads into some direction, the car is off that direction by at least
    begin - s after s, and by end - s when s is left: it turns by 1 per length at most. So it gets no farther than the
    integral of the cosine of these, which is L less begin - sin(begin) + end - sin(end). What is near may be reached
    before these turns are complete, but not sooner than straight on. Backwards the angles are those of the car's back.
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


@compiled
def trace(ground: Ground, car: Car, path: Path) -> list[Segment]:
    """The points of a path; nothing if it comes too close to something."""
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
