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
    """Drive along a path by pursuit of a point ahead: the actions until the car is parked, or None if it is not."""
    actions: list[Hundredths] = []
    number = at = 0
    (way, xs, ys, headings), last = segments[0], len(segments) == 1
    end = len(xs) - 1
    while len(actions) < _LONGEST:
        x, y, heading, speed = car
        rear_x, rear_y = x - HALF * cos(heading), y - HALF * sin(heading)
        while True:
            off = hypot(xs[at] - rear_x, ys[at] - rear_y)
            while at < end and (further := hypot(xs[at + 1] - rear_x, ys[at + 1] - rear_y)) <= off:
                at, off = at + 1, further
            left = (end - at) * SPACING
            if last or left > SPACING or abs(speed) > 0.6:
                break
            number, at = number + 1, 0
            (way, xs, ys, headings), last = segments[number], number + 1 == len(segments)
            end = len(xs) - 1
        bent = abs((headings[at] - heading + pi) % _TURN - pi)
        if off > 1.5 or bent > 0.6:
            return None
        ahead = max(1.5, 0.45 * abs(speed) + 1)
        to = min(end, at + round(ahead / SPACING))
        aim_x, aim_y = xs[to], ys[to]
        if ahead > left:
            aim_x += way * (ahead - left) * cos(headings[to])
            aim_y += way * (ahead - left) * sin(headings[to])
        dx, dy = way * (aim_x - rear_x), way * (aim_y - rear_y)
        angle = (atan2(dy, dx) - heading + pi) % _TURN - pi
        bend = 2 * sin(angle) / max(0.5, hypot(dx, dy)) * way
        wheel = atan(bend * 2 * HALF) / _QUARTER
        fast = min(TOP, sqrt(6 * left + (4 if last else 0)))
        if bent > 0.3:
            fast = min(fast, 2.5)
        pedal = (way * max(0.4, fast) - speed) / PUSH
        action = (
            100 if pedal >= 1 else -100 if pedal <= -1 else round(pedal * 100),
            100 if wheel >= 1 else -100 if wheel <= -1 else round(wheel * 100),
        )
        there = move(ground, car, *action)
        if there is None:
            return None
        car = there
        actions.append(action)
        off_by = excess(ground, car)
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
