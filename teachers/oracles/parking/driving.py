"""Plans for a car among walls and parked cars: Reeds-Shepp paths, driven in an exact model of the car's physics.

A plan is the list of actions that the model drove, so it has been tried out before anybody hears of it. Actions have
two decimals, as they are told. Every function is pure: equal arguments give equal plans.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import product
from math import atan, atan2, cos, hypot, pi, sin, sqrt

from teachers.oracles.parking.model import HALF, PUSH, SURE, Action, Car, Ground, Hundredths, brake, excess, move
from teachers.oracles.parking.paths import SPACING, TOP, Segment, Start, cheapest, trace

_TURN, _QUARTER = 2 * pi, pi / 4
_LONGEST = 90  # actions
_SLOW = 0.5 / 0.45  # m/s below which the point ahead comes no nearer
_OPEN = TOP * TOP
_DRIVEN = 6  # paths that are tried out at most
_ENDS = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
_STRAIGHT_ENDS = ((1.0, 2.0), (1.0, 4.0), (1.0, 6.0), (1.0, 8.0))


@lru_cache(maxsize=4096)
def solve(ground: Ground, car: Car) -> tuple[Action, ...]:
    """Actions that park the car; none if no way was found."""
    if actions := _from(ground, car, (), car):
        return actions
    for before, there in _elsewhere(ground, car):
        if actions := _from(ground, car, before, there):
            return actions
    return ()


def _from(ground: Ground, car: Car, before: tuple[Hundredths, ...], there: Car) -> tuple[Action, ...]:
    """Actions that park the car, as they are told, of which some lead to where a path may begin; none if in doubt."""
    found = _direct(ground, there)
    if found is None:
        return ()
    stop, driven = found
    led = (*before, *stop)
    for count, action in enumerate(led, 1):
        car = move(ground, car, *action) or car  # nothing is touched there
        off_by = excess(ground, car)
        if off_by < SURE:
            return _told(led[:count]) if off_by < -SURE else ()
    return _told((*led, *driven))


def _told(actions: Sequence[Hundredths]) -> tuple[Action, ...]:
    return tuple([(pedal / 100, wheel / 100) for pedal, wheel in actions])


def _direct(ground: Ground, car: Car) -> tuple[tuple[Hundredths, ...], list[Hundredths]] | None:
    """Actions that stop the car first, perhaps none, and those along one path; None if the promising paths fail."""
    starts = list(_starts(ground, car))
    for ends in (_ENDS, _STRAIGHT_ENDS):
        tried = 0
        for path in cheapest(ground, starts, ends):
            before, there = starts[path.start]
            segments = trace(ground, there, path)
            if segments is not None:
                driven = _follow(ground, there, segments)
                if driven is not None:
                    return before, driven
                tried += 1
                if tried == _DRIVEN:
                    break
    return None


def _starts(ground: Ground, car: Car) -> Iterator[Start]:
    """Where a path may begin: here, and where the car comes to a stop; with the actions that lead there."""
    yield (), car
    if abs(car[3]) > PUSH:
        for wheel in (0, 100, -100):
            stop = brake(ground, car, wheel)
            if stop is not None:
                yield stop


def _follow(ground: Ground, car: Car, segments: Sequence[Segment]) -> list[Hundredths] | None:
    """Drive along a path by pursuit of a point ahead: the actions until the car is parked, or None if it is not.

    Most of the time that planning takes is spent here, and so nothing is called that can be written out.
    """
    (goal_x, goal_y, _), tolerance = ground.spot, ground.tolerance + SURE
    actions: list[Hundredths] = []
    number = at = 0
    (way, xs, ys, headings), last = segments[0], len(segments) == 1
    end = len(xs) - 1
    x, y, heading, speed = car
    for _ in range(_LONGEST):
        pace = speed if speed > 0 else -speed
        rear_x, rear_y = x - HALF * cos(heading), y - HALF * sin(heading)
        off = hypot(xs[at] - rear_x, ys[at] - rear_y)
        while True:
            while at < end and (further := hypot(xs[at + 1] - rear_x, ys[at + 1] - rear_y)) <= off:
                at, off = at + 1, further
            left = (end - at) * SPACING
            if last or left > SPACING or pace > 0.6:
                break
            number, at = number + 1, 0
            (way, xs, ys, headings), last = segments[number], number + 1 == len(segments)
            end = len(xs) - 1
            off = hypot(xs[0] - rear_x, ys[0] - rear_y)
        bent = abs((headings[at] - heading + pi) % _TURN - pi)
        if off > 1.5 or bent > 0.6:
            return None
        ahead = 0.45 * pace + 1 if pace > _SLOW else 1.5
        to = at + round(ahead / SPACING)
        if to > end:
            to = end
        dx, dy = xs[to] - rear_x, ys[to] - rear_y
        if ahead > left:
            dx = xs[to] + way * (ahead - left) * cos(headings[to]) - rear_x
            dy = ys[to] + way * (ahead - left) * sin(headings[to]) - rear_y
        if way < 0:
            dx, dy = -dx, -dy
        far = hypot(dx, dy)
        bend = 2 * sin(atan2(dy, dx) - heading) / (far if far > 0.5 else 0.5) * way
        room = 6 * left + 4 if last else 6 * left
        fast = sqrt(room) if room < _OPEN else TOP
        if bent > 0.3 and fast > 2.5:
            fast = 2.5
        pedal = (way * (fast if fast > 0.4 else 0.4) - speed) / PUSH
        wheel = atan(bend * 2 * HALF) / _QUARTER
        action = (
            100 if pedal >= 1 else -100 if pedal <= -1 else round(pedal * 100),
            100 if wheel >= 1 else -100 if wheel <= -1 else round(wheel * 100),
        )
        there = move(ground, (x, y, heading, speed), *action)
        if there is None:
            return None
        x, y, heading, speed = there
        actions.append(action)
        if abs(x - goal_x) + 0.3 * abs(y - goal_y) < tolerance:
            off_by = excess(ground, there)
            if off_by < SURE:
                return actions if off_by < -SURE else None
        if last and left <= 0 and off > 2:
            return None
    return None


def _elsewhere(ground: Ground, car: Car) -> Iterator[tuple[tuple[Hundredths, ...], Car]]:
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
