"""An exact model of the car: where an action leads, and whether anything is in the way.

The simulator's own arithmetic is repeated operation by operation, so that both agree.
"""

import math
from collections.abc import Sequence
from math import cos, sin
from typing import NamedTuple

import numpy as np

Action = tuple[float, float]
Car = tuple[float, float, float, float]
"""Position of the middle in m, heading in radians, speed in m/s."""
Hundredths = tuple[int, int]
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
STEPS = 3
"""Of the model, in an action."""
DT = 1 / 15
"""Seconds that a step takes."""
HALF = 2.5
"""Half of the car's length, which is its wheelbase, too, in m."""
PUSH = 1.0
"""Change of speed, in m/s, by an action of 1."""
SURE = 1e-9
"""What the simulator may see otherwise."""
_STEPS = range(STEPS)
_SIDE = 1.0  # half of the car's width, in m
_CORNER = math.hypot(HALF, _SIDE)
_MARGIN = 0.04  # m to keep from what may not be touched
_REACH = _CORNER + _MARGIN


def _gain() -> tuple[float, ...]:
    pedal = -5 + (np.arange(-100, 101).astype(np.float32) / np.float32(100) + 1) * 10.0 / 2
    return tuple([each * DT for each in pedal.tolist()])


def _wheel() -> tuple[tuple[float, float], ...]:
    quarter = np.pi / 4
    share = (np.arange(-100, 101) / 100).astype(np.float32)
    steering = (-quarter + (share + 1) * (2 * quarter) / 2).astype(np.float64)
    slip = np.arctan(1 / 2 * np.tan(steering))
    return tuple(zip(slip.tolist(), np.sin(slip).tolist(), strict=True))


_GAIN = _gain()
"""Change of speed in a step, in m/s, by hundredths of an action, rounded as highway-env rounds float32."""
_WHEEL = _wheel()
"""Slip angle in radians, with its sine, by hundredths of an action."""


def misfit(ground: Ground, x: float, y: float, heading: float) -> float:
    """How far a car is from being parked; it is parked below the ground's tolerance."""
    goal_x, goal_y, goal = ground.spot
    turned = abs(cos(heading) - cos(goal)) + abs(sin(heading) - sin(goal))
    return abs(x - goal_x) + 0.3 * abs(y - goal_y) + 2 * turned


def excess(ground: Ground, car: Car) -> float:
    """The misfit of a car less what is tolerated; less than that where its place alone is too far away."""
    goal_x, goal_y, _ = ground.spot
    x, y, heading, _ = car
    away = abs(x - goal_x) + 0.3 * abs(y - goal_y) - ground.tolerance
    return away if away >= SURE else misfit(ground, x, y, heading) - ground.tolerance


def move(ground: Ground, car: Car, pedal: int, wheel: int, caution: int = 1) -> Car | None:
    """Where an action, in hundredths, leads; None if that comes too close to something.

    With a caution of -1 it is None only if something is surely touched: the margin is the other way.
    """
    x, y, heading, speed = car
    gain = _GAIN[pedal + 100]
    slip, sine = _WHEEL[wheel + 100]
    near = None
    # More than the car, with its margin, needs in the whole action.
    reach = _REACH + 0.3 + 0.3 * (speed if speed > 0 else -speed)
    across, along = ground.wall_x - reach, ground.wall_y - reach
    if ground.parked or not (-across < x < across and -along < y < along):
        near = _near(ground, x, y, reach, reach)
    if near is None:
        for _ in _STEPS:
            course = heading + slip
            x += speed * cos(course) * DT
            y += speed * sin(course) * DT
            heading += speed * sine / HALF * DT
            speed += gain
        return x, y, heading, speed
    for _ in _STEPS:
        course = heading + slip
        x += speed * cos(course) * DT
        y += speed * sin(course) * DT
        heading += speed * sine / HALF * DT
        speed += gain
        if not _free(ground, near, x, y, heading, caution * (_MARGIN + abs(speed) * DT)):
            return None
    return x, y, heading, speed


def has_room(ground: Ground, xs: Sequence[float], ys: Sequence[float], headings: Sequence[float], room: float) -> bool:
    """Whether the car has so much room around it wherever its rear axle is, in all of these places."""
    west, east, north, south = min(xs), max(xs), min(ys), max(ys)
    reach = HALF + _CORNER + room
    near = _near(ground, (west + east) / 2, (north + south) / 2, (east - west) / 2 + reach, (south - north) / 2 + reach)
    if near is None:
        return True
    open_x, open_y = (-1.0, -1.0) if near else (ground.wall_x - reach, ground.wall_y - reach)
    return all(
        (abs(x) < open_x and abs(y) < open_y)
        or _free(ground, near, x + HALF * cos(heading), y + HALF * sin(heading), heading, room)
        for x, y, heading in zip(xs, ys, headings, strict=True)
    )


def _near(ground: Ground, x: float, y: float, wide: float, high: float) -> list[tuple[float, float]] | None:
    """The cars that reach into a box about a point, of such half sides; None if no wall does either."""
    across, along = wide + _SIDE, high + HALF
    near = [each for each in ground.parked if abs(each[0] - x) < across and abs(each[1] - y) < along]
    return near if near or abs(x) + wide > ground.wall_x or abs(y) + high > ground.wall_y else None


def _free(
    ground: Ground, near: Sequence[tuple[float, float]], x: float, y: float, heading: float, margin: float
) -> bool:
    """Whether a car there keeps the margin to the walls and to the cars that are near."""
    cosine, sine = cos(heading), sin(heading)
    along, across = abs(cosine), abs(sine)
    width, height = along * HALF + across * _SIDE + margin, across * HALF + along * _SIDE + margin
    if abs(x) + width >= ground.wall_x or abs(y) + height >= ground.wall_y:
        return False
    for other_x, other_y in near:
        dx, dy = other_x - x, other_y - y
        if (
            abs(dx) <= width + _SIDE
            and abs(dy) <= height + HALF
            and abs(dx * cosine + dy * sine) <= HALF + margin + along * _SIDE + across * HALF
            and abs(dy * cosine - dx * sine) <= _SIDE + margin + across * _SIDE + along * HALF
        ):
            return False
    return True


def brake(ground: Ground, car: Car, wheel: int, caution: int = 1) -> tuple[tuple[Hundredths, ...], Car] | None:
    """Full braking with the wheel held, in hundredths: the actions and where the car stops, or None if it crashes.

    The caution is that of `move`.
    """
    actions = []
    there: Car | None = car
    while there is not None and abs(there[3]) > 0.05:
        pedal = round(min(max(-there[3] / PUSH, -1.0), 1.0) * 100)
        actions.append((pedal, wheel))
        there = move(ground, there, pedal, wheel, caution)
    return None if there is None else (tuple(actions), there)


def can_stop(ground: Ground, car: Car, caution: int = 1) -> bool:
    """Whether the car can be braked to a halt with one of the `BRAKES`; the caution is that of `move`."""
    return any(brake(ground, car, round(wheel * 100), caution) is not None for wheel in BRAKES)


def misses(ground: Ground, car: Car, actions: Sequence[Action]) -> bool:
    """Whether actions of two decimals surely do not park the car on the way, nor touch anything."""
    for pedal, wheel in actions:
        there = move(ground, car, round(pedal * 100), round(wheel * 100))
        if there is None or excess(ground, there) < SURE:
            return False
        car = there
    return True
