"""An exact model of the car: the result of an action, and whether there is an obstacle.

Its steps are those of the simulator, `worlds.parking.step_car`, to the last bit. They are written out here, because
most of the time of planning goes into them, and a call for each doubles it.
"""

import math
from collections.abc import Sequence
from math import cos, sin
from typing import NamedTuple

import numpy as np

from worlds.parking import DT

Action = tuple[float, float]
Car = tuple[float, float, float, float]
"""Position of the middle in m, heading in radians, speed in m/s."""
Hundredths = tuple[int, int]
"""An action in hundredths."""


class Ground(NamedTuple):
    """The car park: the spot and the obstacles."""

    spot: tuple[float, float, float]
    """Position in m and heading in radians."""
    tolerance: float
    """The car is parked if its `misfit` is below this."""
    parked: tuple[tuple[float, float], ...]
    """The middles of the parked cars, whose headings are along the y axis."""
    wall_x: float
    wall_y: float
    """The walls' inner faces are at plus and minus these, in m."""
    caution: int = 1
    """1: a car keeps a margin to obstacles; -1: the margin is negative, so that only what certainly touches does."""


BRAKES = (-1.0, -0.5, 0.0, 0.5, 1.0)
"""Positions of the wheel that are tried in full braking."""
TOLERANCE = 1.44
"""highway-env's threshold for the reward, squared and counted in metres."""
STEPS = 3
"""Simulation steps in an action."""
HALF = 2.5
"""Half of the car's length, in m; also its wheelbase."""
PUSH = 1.0
"""Change of speed, in m/s, by an action of 1."""
SURE = 1e-9
"""Bound of rounding differences to the simulator."""
_SIDE = 1.0  # half of the car's width, in m
_CORNER = math.hypot(HALF, _SIDE)
_MARGIN = 0.04  # m to keep from obstacles
REACH = _CORNER + _MARGIN + 0.3
"""In an action, a car does not touch what is farther from its middle than this, in m, plus 0.3 s of its speed."""


def _gain() -> tuple[float, ...]:
    pedal = -5 + (np.arange(-100, 101).astype(np.float32) / np.float32(100) + 1) * 10.0 / 2
    return tuple([each * DT for each in pedal.tolist()])


def _wheel() -> tuple[tuple[float, float], ...]:
    quarter = np.pi / 4
    share = (np.arange(-100, 101) / 100).astype(np.float32)
    steering = (-quarter + (share + 1) * (2 * quarter) / 2).astype(np.float64)
    slip = np.arctan(1 / 2 * np.tan(steering))
    return tuple(zip(slip.tolist(), np.sin(slip).tolist(), strict=True))


GAIN = _gain()
"""Change of speed in a step, in m/s, by hundredths of an action, rounded as highway-env rounds float32."""
WHEEL = _wheel()
"""Slip angle in radians, with its sine, by hundredths of an action."""


def misfit(ground: Ground, x: float, y: float, heading: float) -> float:
    """The weighted distance of a car from the parked pose, in m; it is parked below the tolerance."""
    goal_x, goal_y, goal = ground.spot
    turned = abs(cos(heading) - cos(goal)) + abs(sin(heading) - sin(goal))
    return abs(x - goal_x) + 0.3 * abs(y - goal_y) + 2 * turned


def excess(ground: Ground, car: Car) -> float:
    """The misfit of a car minus the tolerance; less than that where its position alone exceeds the tolerance."""
    (goal_x, goal_y, _), tolerance = ground.spot, ground.tolerance
    x, y, heading, _ = car
    away = abs(x - goal_x) + 0.3 * abs(y - goal_y) - tolerance
    return away if away >= SURE else misfit(ground, x, y, heading) - tolerance


def move(ground: Ground, car: Car, pedal: int, wheel: int) -> Car | None:
    """The car after an action, in hundredths; None if it comes too close to an obstacle."""
    x, y, heading, speed = car
    # More than the car covers, with its margin, in the whole action.
    reach = REACH + 0.3 * (speed if speed > 0 else -speed)
    across, along = ground.wall_x - reach, ground.wall_y - reach
    near = _near(ground, x, y, reach, reach) if ground.parked else []
    clear = not near and -across < x < across and -along < y < along
    gain, (slip, sine) = GAIN[pedal + 100], WHEEL[wheel + 100]
    for _ in range(STEPS):
        course = heading + slip
        x += speed * cos(course) * DT
        y += speed * sin(course) * DT
        heading += speed * sine / HALF * DT
        speed += gain
        if not clear:
            margin = ground.caution * (_MARGIN + abs(speed) * DT)
            if not _free(ground, near, x, y, cos(heading), sin(heading), margin):
                return None
    return x, y, heading, speed


def has_room(ground: Ground, xs: list[float], ys: list[float], headings: list[float], run: float, room: float) -> bool:
    """Whether the car has this much room around it with its rear axle in each of these poses.

    None of them is farther than `run` from the first.
    """
    reach = HALF + _CORNER + room
    across, along = ground.wall_x - reach, ground.wall_y - reach
    clear = abs(xs[0]) + run < across and abs(ys[0]) + run < along
    if clear and not ground.parked:
        return True
    west, east, north, south = min(xs), max(xs), min(ys), max(ys)
    x, y = (west + east) / 2, (north + south) / 2
    near = _near(ground, x, y, (east - west) / 2 + reach, (south - north) / 2 + reach)
    if near:
        across = along = -1.0
    for x, y, heading in zip(xs, ys, headings):  # noqa: B905  # all have a length
        if abs(x) >= across or abs(y) >= along:
            cosine, sine = cos(heading), sin(heading)
            if not _free(ground, near, x + HALF * cosine, y + HALF * sine, cosine, sine, room):
                return False
    return True


def _near(ground: Ground, x: float, y: float, wide: float, high: float) -> list[tuple[float, float]]:
    """The parked cars that overlap a box around a point, given its half sides."""
    across, along = wide + _SIDE, high + HALF
    return [each for each in ground.parked if abs(each[0] - x) < across and abs(each[1] - y) < along]


def _free(
    ground: Ground, near: list[tuple[float, float]], x: float, y: float, cosine: float, sine: float, margin: float
) -> bool:
    """Whether a car in this pose keeps the margin to the walls and to the cars of `near`."""
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


def brake(ground: Ground, car: Car, wheel: int) -> tuple[bool, list[Hundredths], Car]:
    """Brake fully with the wheel held, in hundredths: whether the car stops, the actions, and the car after them.

    If it crashes, the actions are those before the crash.
    """
    actions: list[Hundredths] = []
    x, y, heading, speed = car
    while abs(speed) > 0.05:
        pedal = round(min(max(-speed / PUSH, -1.0), 1.0) * 100)
        there = move(ground, (x, y, heading, speed), pedal, wheel)
        if there is None:
            return False, actions, (x, y, heading, speed)
        x, y, heading, speed = there
        actions.append((pedal, wheel))
    return True, actions, (x, y, heading, speed)


def can_stop(ground: Ground, car: Car) -> bool:
    """Whether the car stops with one of the `BRAKES`."""
    return any(brake(ground, car, round(wheel * 100))[0] for wheel in BRAKES)


def misses(ground: Ground, car: Car, actions: Sequence[Action]) -> bool:
    """Whether actions with two decimals do not park the car, not even on the way, and do not touch anything."""
    for pedal, wheel in actions:
        there = move(ground, car, round(pedal * 100), round(wheel * 100))
        if there is None or excess(ground, there) < SURE:
            return False
        car = there
    return True
