"""Plans for a car among walls and parked cars: Reeds-Shepp paths, driven in an exact model of the car's physics.

A plan is a list of actions that parked the car in the model. Actions have two decimals, as in claims. Every function
is pure: equal arguments give equal plans.
"""

from math import atan, cos, inf, pi, sin, sqrt

from teachers.oracles.parking.model import (
    GAIN,
    HALF,
    PUSH,
    REACH,
    STEPS,
    SURE,
    WHEEL,
    Action,
    Car,
    Ground,
    Hundredths,
    brake,
    excess,
    move,
)
from teachers.oracles.parking.paths import SPACING, TOP, Segment, cheapest, paths, targets, trace
from worlds.parking import DT

_TURN, _QUARTER = 2 * pi, pi / 4
_LONGEST = 90  # actions
_ASTRAY = 1.5 * 1.5  # square of the distance from the path, in m, at which pursuit is given up
_DEARER = 8.0  # m by which the cost of a path to try first may exceed the least cost
_DRIVEN = 6  # greatest number of paths to drive
_ENDS = ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
_STRAIGHT_ENDS = ((1.0, 2.0), (1.0, 4.0), (1.0, 6.0), (1.0, 8.0))


def solve(ground: Ground, car: Car) -> tuple[Action, ...]:
    """Actions that park the car; empty if none were found."""
    return tuple([(pedal / 100, wheel / 100) for pedal, wheel in _solve(ground, car)])


def _solve(ground: Ground, car: Car) -> list[Hundredths]:
    actions = _from(ground, car, [], car)
    if actions:
        return actions
    for times in (1, 4, 7):
        for pedal in (-100, 100, 0):
            for wheel in range(-100, 101, 50):
                actions = _after(ground, car, [(pedal, wheel)] * times)
                if actions:
                    return actions
    return []


def _after(ground: Ground, car: Car, before: list[Hundredths]) -> list[Hundredths]:
    """Actions that park the car, beginning with these and full braking; empty if none were found."""
    x, y, heading, speed = car
    for pedal, wheel in before:
        there = move(ground, (x, y, heading, speed), pedal, wheel)
        if there is None:
            return []
        x, y, heading, speed = there
    for held in range(-100, 101, 25):
        stops, stop, halt = brake(ground, (x, y, heading, speed), held)
        if stops and stop:
            actions = _from(ground, car, before + stop, halt)
            if actions or len(before) > 1:
                return actions
    return []


def _from(ground: Ground, car: Car, before: list[Hundredths], there: Car) -> list[Hundredths]:
    """Actions that park the car, of which `before` lead to `there`, where a path begins; empty if none were found."""
    stop, driven = _direct(ground, there)
    if not driven:
        return driven
    led = before + stop
    x, y, heading, speed = car
    for count, action in enumerate(led):
        after = move(ground, (x, y, heading, speed), action[0], action[1])
        if after is not None:  # nothing is touched there
            x, y, heading, speed = after
        off_by = excess(ground, (x, y, heading, speed))
        if off_by < SURE:
            return led[: count + 1] if off_by < -SURE else []
    return led + driven


def _direct(ground: Ground, car: Car) -> tuple[list[Hundredths], list[Hundredths]]:
    """Actions that stop the car, if needed, and those along a path; empty if the paths that are tried fail."""
    starts: list[tuple[int, Car]] = [(0, car)]
    stops: list[list[Hundredths]] = [[]]
    if abs(car[3]) > PUSH:
        for wheel in (0, 100, -100):
            stopped, actions, halt = brake(ground, car, wheel)
            if stopped:
                starts.append((len(actions), halt))
                stops.append(actions)
    for ends in (_ENDS, _STRAIGHT_ENDS):
        there = targets(ground, starts, ends)
        found = first = cheapest(there)  # which mostly succeeds
        known = tried = 0
        for dearer in (0.0, _DEARER, inf):
            if dearer and first:
                found = paths(there, first[0].cost + dearer)
            for path in found[known:]:
                begin = starts[path.start][1]
                if tried == _DRIVEN:
                    break
                segments = trace(ground, begin, path)
                if segments:
                    driven = _follow(ground, begin, segments)
                    if driven:
                        return stops[path.start], driven
                    tried += 1
            known = len(found)
            if tried == _DRIVEN:
                break
    return [], []


def _follow(ground: Ground, car: Car, segments: list[Segment]) -> list[Hundredths]:
    """Drive along a path by pursuit of a point ahead: the actions that park the car; empty if it is not parked.

    This takes most of the time of planning.
    """
    (goal_x, goal_y, _), tolerance = ground.spot, ground.tolerance + SURE
    clear_x, clear_y = ground.wall_x - REACH, ground.wall_y - REACH
    if ground.parked:
        clear_x = clear_y = 0.0  # there are other obstacles than walls
    actions: list[Hundredths] = []
    number = at = 0
    (way, xs, ys, headings), last = segments[0], len(segments) == 1
    end = len(xs) - 1
    x, y, heading, speed = car
    for _ in range(_LONGEST):
        pace = speed if speed > 0 else -speed
        cosine, sine = cos(heading), sin(heading)
        rear_x, rear_y = x - HALF * cosine, y - HALF * sine
        dx, dy = xs[at] - rear_x, ys[at] - rear_y
        off = dx * dx + dy * dy
        while True:
            while at < end:
                dx, dy = xs[at + 1] - rear_x, ys[at + 1] - rear_y
                further = dx * dx + dy * dy
                if further > off:
                    break
                at, off = at + 1, further
            left = (end - at) * SPACING
            if last or left > SPACING or pace > 0.6:
                break
            number, at = number + 1, 0
            (way, xs, ys, headings), last = segments[number], number + 1 == len(segments)
            end = len(xs) - 1
            dx, dy = xs[0] - rear_x, ys[0] - rear_y
            off = dx * dx + dy * dy
        bent = abs((headings[at] - heading + pi) % _TURN - pi)
        if off > _ASTRAY or bent > 0.6:
            return []
        ahead = 0.45 * pace + 1
        if ahead < 1.5:
            ahead = 1.5
        to = at + round(ahead / SPACING)
        if to > end:
            to = end
        dx, dy = xs[to] - rear_x, ys[to] - rear_y
        if ahead > left:
            dx = xs[to] + way * (ahead - left) * cos(headings[to]) - rear_x
            dy = ys[to] + way * (ahead - left) * sin(headings[to]) - rear_y
        far = dx * dx + dy * dy
        bend = 2 * (dy * cosine - dx * sine) / (far if far > 0.25 else 0.5 * sqrt(far) + SURE)
        fast, most = 6 * left + 4 if last else 6 * left, 2.5 if bent > 0.3 else TOP
        fast = sqrt(fast) if fast < most * most else most
        pedal = (way * (fast if fast > 0.4 else 0.4) - speed) / PUSH
        wheel = atan(bend * 2 * HALF) / _QUARTER
        action = (
            100 if pedal >= 1 else -100 if pedal <= -1 else round(pedal * 100),
            100 if wheel >= 1 else -100 if wheel <= -1 else round(wheel * 100),
        )
        if abs(x) + 0.3 * pace < clear_x and abs(y) + 0.3 * pace < clear_y:  # without this a turn takes 12 % longer
            gain, (slip, sine) = GAIN[action[0] + 100], WHEEL[action[1] + 100]
            for _ in range(STEPS):  # as in `move`
                course = heading + slip
                x += speed * cos(course) * DT
                y += speed * sin(course) * DT
                heading += speed * sine / HALF * DT
                speed += gain
        else:
            there = move(ground, (x, y, heading, speed), action[0], action[1])
            if there is None:
                return []
            x, y, heading, speed = there
        actions.append(action)
        if abs(x - goal_x) + 0.3 * abs(y - goal_y) < tolerance:
            off_by = excess(ground, (x, y, heading, speed))
            if off_by < SURE:
                return actions if off_by < -SURE else []
    return []
