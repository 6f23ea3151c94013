"""Plans for a car among walls and parked cars: Reeds-Shepp paths, driven in an exact model of the car's physics.

A plan is the list of actions that the model drove, so it has been tried out before anybody hears of it. Actions have
two decimals, as they are told. Every function is pure: equal arguments give equal plans.
"""

import math
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from itertools import product
from operator import itemgetter
from typing import NamedTuple

import numpy as np

from teachers.oracles.parking.reeds_shepp import Word, words, wrapped

Action = tuple[float, float]
Car = tuple[float, float, float, float]
"""Position of the middle in m, heading in radians, speed in m/s."""
_Hundredths = tuple[int, int]
"""An action, in hundredths."""


class Ground(NamedTuple):
    """Where the car may be and where it is to go."""

    spot: tuple[float, float, float]
    """Position in m and heading in radians."""
    tolerance: float
    """How far off the car may be; see `misfit`."""
    parked: tuple[tuple[float, float], ...]
    """The middles of cars that stand in rows along the y axis."""
    wall_x: float
    wall_y: float
    """The walls' inner faces lie at plus and minus these, in m."""


BRAKES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Positions of the wheel with which a car that brakes as hard as it can may still be saved."""
STEPS = 3  # of the model in an action
DT = 1 / 15  # seconds a step
_HALF = 2.5  # half of the car's length, which is its wheelbase, too, in m
_SIDE = 1.0  # half of its width, in m
_CORNER = math.hypot(_HALF, _SIDE)
_MARGIN = 0.04  # m to keep from what may not be touched
_PUSH = 1.0  # change of speed, in m/s, by an action of 1
_RADIUS = 5.6  # of planned arcs, in m; the car's own is 5
_SPACING = 0.5  # between the points of a path, in m
_TOP = 5.0  # m/s
_LONGEST = 90  # actions
_DRIVEN = 6  # paths that are tried out at most
_ENDS = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
"""How far from the middle of the spot a path may end, since the car is parked before, and how straight it gets there,
in m."""
_STRAIGHT_ENDS = ((1.0, 2.0), (1.0, 4.0), (1.0, 6.0), (1.0, 8.0))
_SURE = 1e-9  # what the simulator may see otherwise
_CUSP = 4.0  # m that a change of direction is thought to cost


@cache
def _pedal() -> tuple[float, ...]:
    """Acceleration, in m/s2, by hundredths of an action, rounded as highway-env rounds actions of type float32."""
    return tuple((-5 + (np.arange(-100, 101).astype(np.float32) / np.float32(100) + 1) * 10.0 / 2).tolist())


@cache
def _wheel() -> tuple[tuple[float, float], ...]:
    """Slip angle in radians, with its sine, by hundredths of an action."""
    quarter = np.pi / 4
    share = (np.arange(-100, 101) / 100).astype(np.float32)
    steering = (-quarter + (share + 1) * (2 * quarter) / 2).astype(np.float64)
    slip = np.arctan(1 / 2 * np.tan(steering))
    return tuple(zip(slip.tolist(), np.sin(slip).tolist(), strict=True))


def misfit(ground: Ground, x: float, y: float, heading: float) -> float:
    """How far a car is from being parked; it is parked below the ground's tolerance."""
    goal_x, goal_y, goal = ground.spot
    turned = abs(math.cos(heading) - math.cos(goal)) + abs(math.sin(heading) - math.sin(goal))
    return abs(x - goal_x) + 0.3 * abs(y - goal_y) + 2 * turned


def move(ground: Ground, car: Car, pedal: int, wheel: int) -> Car | None:
    """Where an action, in hundredths, leads; None if that comes too close to something."""
    x, y, heading, speed = car
    acceleration, (slip, sine) = _pedal()[pedal + 100], _wheel()[wheel + 100]
    for _ in range(STEPS):
        x += speed * math.cos(heading + slip) * DT
        y += speed * math.sin(heading + slip) * DT
        heading += speed * sine / _HALF * DT
        speed += acceleration * DT
        if not _free(ground, x, y, heading, _MARGIN + abs(speed) * DT):
            return None
    return x, y, heading, speed


def _free(ground: Ground, x: float, y: float, heading: float, margin: float) -> bool:
    """Whether a car there has so much room around it."""
    reach = _CORNER + margin
    near_wall = abs(x) + reach > ground.wall_x or abs(y) + reach > ground.wall_y
    near = [each for each in ground.parked if abs(each[0] - x) < reach + _SIDE and abs(each[1] - y) < reach + _HALF]
    if not near_wall and not near:
        return True
    cos, sin = math.cos(heading), math.sin(heading)
    along, across = abs(cos), abs(sin)
    width, height = along * _HALF + across * _SIDE + margin, across * _HALF + along * _SIDE + margin
    if abs(x) + width >= ground.wall_x or abs(y) + height >= ground.wall_y:
        return False
    for other_x, other_y in near:
        dx, dy = other_x - x, other_y - y
        if (
            abs(dx) <= width + _SIDE
            and abs(dy) <= height + _HALF
            and abs(dx * cos + dy * sin) <= _HALF + margin + along * _SIDE + across * _HALF
            and abs(dy * cos - dx * sin) <= _SIDE + margin + across * _SIDE + along * _HALF
        ):
            return False
    return True


@lru_cache(maxsize=4096)
def solve(ground: Ground, car: Car) -> tuple[Action, ...]:
    """Actions that park the car; none if no way was found."""
    if actions := _until_parked(ground, car, _direct(ground, car)):
        return actions
    for before, there in _elsewhere(ground, car):
        if (further := _direct(ground, there)) and (actions := _until_parked(ground, car, before + further)):
            return actions
    return ()


def _until_parked(ground: Ground, car: Car, actions: Sequence[_Hundredths]) -> tuple[Action, ...]:
    """The actions as they are told, up to the first that parks the car; none if that one is in doubt."""
    there: Car | None = car
    for count, action in enumerate(actions, 1):
        there = there and move(ground, there, *action)
        if there is None:
            break
        off_by = misfit(ground, *there[:3]) - ground.tolerance
        if off_by < _SURE:
            return tuple([(pedal / 100, wheel / 100) for pedal, wheel in actions[:count]]) if off_by < -_SURE else ()
    return ()


def _direct(ground: Ground, car: Car) -> tuple[_Hundredths, ...]:
    """Actions along one path; none if the promising ones fail. Those before the path may park the car already."""
    starts = list(_starts(ground, car))
    for ends in (_ENDS, _STRAIGHT_ENDS):
        tried = 0
        for _, start, path in sorted(_paths(ground, starts, ends), key=itemgetter(0)):
            before, there = starts[start]
            segments = _trace(ground, there, path)
            if segments is not None:
                driven = _follow(ground, there, segments)
                if driven is not None:
                    return (*before, *driven)
                tried += 1
                if tried == _DRIVEN:
                    break
    return ()


def _starts(ground: Ground, car: Car) -> Iterator[tuple[tuple[_Hundredths, ...], Car]]:
    """Where a path may begin: here, and where the car comes to a stop; with the actions that lead there."""
    yield (), car
    if abs(car[3]) > _PUSH:
        for wheel in (0, 100, -100):
            stop = brake(ground, car, wheel)
            if stop is not None:
                yield stop


def brake(ground: Ground, car: Car, wheel: int) -> tuple[tuple[_Hundredths, ...], Car] | None:
    """Full braking with the wheel held, in hundredths: the actions and where the car stops, or None if it crashes."""
    actions = []
    there: Car | None = car
    while there is not None and abs(there[3]) > 0.05:
        pedal = round(min(max(-there[3] / _PUSH, -1.0), 1.0) * 100)
        actions.append((pedal, wheel))
        there = move(ground, there, pedal, wheel)
    return None if there is None else (tuple(actions), there)


def _paths(
    ground: Ground, starts: Sequence[tuple[tuple[_Hundredths, ...], Car]], ends: Sequence[tuple[float, float]]
) -> Iterator[tuple[float, int, Word]]:
    """Paths of the rear axle to the spot, each with its estimated cost in m and its start."""
    goal_x, goal_y, goal = ground.spot
    goal_cos, goal_sin = math.cos(goal), math.sin(goal)
    for index, (before, (x, y, heading, speed)) in enumerate(starts):
        cos, sin = math.cos(heading), math.sin(heading)
        rear_x, rear_y, turn = x - _HALF * cos, y - _HALF * sin, wrapped(goal - heading)
        for short, straight in ends if not before else ends[::2]:
            dx = (goal_x - (_HALF + short + straight) * goal_cos - rear_x) / _RADIUS
            dy = (goal_y - (_HALF + short + straight) * goal_sin - rear_y) / _RADIUS
            for pieces, lengths in words(cos * dx + sin * dy, cos * dy - sin * dx, turn):
                if straight:
                    pieces, lengths = pieces + "S", (*lengths, straight / _RADIUS)
                cost, way = short + len(before) * DT * STEPS * _TOP, 0.0
                for length in lengths:
                    if abs(length) > 1e-6:
                        cost += abs(length) * _RADIUS
                        if way * length < 0:
                            cost += _CUSP
                        elif not way and speed * length < 0:
                            cost += speed * speed / 5 + abs(speed)
                        way = length
                yield cost, index, Word(pieces, lengths)


class _Segment(NamedTuple):
    """A part of a path that is driven in one direction."""

    way: int
    """1 forwards, -1 backwards."""
    points: list[tuple[float, float, float]]
    """Position and heading of the rear axle."""


def _trace(ground: Ground, car: Car, path: Word) -> list[_Segment] | None:
    """The points of a path, or None if it comes too close to something."""
    x, y, heading, _ = car
    x, y = x - _HALF * math.cos(heading), y - _HALF * math.sin(heading)
    segments: list[_Segment] = []
    for piece, length in zip(*path, strict=True):
        if abs(length) < 1e-6:
            continue
        way = 1 if length > 0 else -1
        if not segments or segments[-1].way != way:
            segments.append(_Segment(way, [(x, y, heading)]))
        points = segments[-1].points
        count = math.ceil(abs(length) * _RADIUS / _SPACING)
        step = length * _RADIUS / count
        bend = 0.0 if piece == "S" else step / _RADIUS if piece == "L" else -step / _RADIUS
        chord = step if not bend else step * math.sin(bend / 2) / (bend / 2)
        for _ in range(count):
            x += chord * math.cos(heading + bend / 2)
            y += chord * math.sin(heading + bend / 2)
            heading += bend
            points.append((x, y, heading))
            middle_x, middle_y = x + _HALF * math.cos(heading), y + _HALF * math.sin(heading)
            if not _free(ground, middle_x, middle_y, heading, 0.3):
                return None
    return segments


def _follow(ground: Ground, car: Car, segments: list[_Segment]) -> list[_Hundredths] | None:
    """Drive along a path by pursuit of a point ahead: the actions until the car is parked, or None if it is not."""
    actions: list[_Hundredths] = []
    number = at = 0
    while len(actions) < _LONGEST:
        x, y, heading, speed = car
        rear_x, rear_y = x - _HALF * math.cos(heading), y - _HALF * math.sin(heading)
        while True:
            way, points = segments[number]
            end = len(points) - 1
            off = math.dist(points[at][:2], (rear_x, rear_y))
            while at < end and (further := math.dist(points[at + 1][:2], (rear_x, rear_y))) <= off:
                at, off = at + 1, further
            left = (end - at) * _SPACING
            last = number == len(segments) - 1
            if last or left > _SPACING or abs(speed) > 0.6:
                break
            number, at = number + 1, 0
        bent = abs(wrapped(points[at][2] - heading))
        if off > 1.5 or bent > 0.6:
            return None
        ahead = max(1.5, 0.45 * abs(speed) + 1)
        aim_x, aim_y, aim = points[min(end, at + round(ahead / _SPACING))]
        if ahead > left:
            aim_x += way * (ahead - left) * math.cos(aim)
            aim_y += way * (ahead - left) * math.sin(aim)
        dx, dy = way * (aim_x - rear_x), way * (aim_y - rear_y)
        angle = wrapped(math.atan2(dy, dx) - heading)
        bend = 2 * math.sin(angle) / max(0.5, math.hypot(dx, dy)) * way
        wheel = math.atan(bend * 2 * _HALF) / (math.pi / 4)
        fast = min(_TOP, math.sqrt(6 * left + (4 if last else 0)))
        fast = max(0.4, min(fast, 2.5) if bent > 0.3 else fast)
        pedal = (way * fast - speed) / _PUSH
        action = round(min(max(pedal, -1.0), 1.0) * 100), round(min(max(wheel, -1.0), 1.0) * 100)
        there = move(ground, car, *action)
        if there is None:
            return None
        car = there
        actions.append(action)
        off_by = misfit(ground, car[0], car[1], car[2]) - ground.tolerance
        if off_by < _SURE:
            return actions if off_by < -_SURE else None
        if last and left <= 0 and off > 2:
            return None
    return None


def _elsewhere(ground: Ground, car: Car) -> Iterator[tuple[tuple[_Hundredths, ...], Car]]:
    """Other places to stop at: after a few equal actions and full braking with any wheel; with the way there."""
    for times, pedal, wheel in product((1, 4, 7), (-100, 100, 0), range(-100, 101, 50)):
        there: Car | None = car
        for _ in range(times):
            there = there and move(ground, there, pedal, wheel)
        if there is not None:
            for held in range(-100, 101, 25):
                stop = brake(ground, there, held)
                if stop is not None and stop[0]:
                    yield ((pedal, wheel),) * times + stop[0], stop[1]
                    if times > 1:
                        break


def misses(ground: Ground, car: Car, actions: Sequence[Action]) -> bool:
    """Whether actions of two decimals surely do not park the car on the way, nor touch anything."""
    for pedal, wheel in actions:
        there = move(ground, car, round(pedal * 100), round(wheel * 100))
        if there is None or misfit(ground, *there[:3]) < ground.tolerance + _SURE:
            return False
        car = there
    return True


def can_stop(ground: Ground, car: Car) -> bool:
    """Whether the car can be braked to a halt with one of the `BRAKES`."""
    return any(brake(ground, car, round(wheel * 100)) is not None for wheel in BRAKES)
