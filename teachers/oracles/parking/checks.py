"""Checks of claims about parking, by drives in the simulator, and words for actions."""

import math
from collections.abc import Sequence
from itertools import product
from weakref import WeakKeyDictionary

from teachers.oracles.parking.model import BRAKES
from worlds.parking import LENGTH, Action, Parking, Truth

PEDALS = ("push backwards", "leave the pedals alone", "push forwards")
"""Positions of the pedals in words."""
WHEELS = ("turn the wheel to the left", "hold the wheel straight", "turn the wheel to the right")
"""Positions of the wheel in words."""


SIDES = {"left": -1, "right": 1}
"""The sign of angles to each side of the driver."""


def after_action(lab: Parking, truth: Truth, action: Action) -> Truth:
    """The truth after an action in the simulator."""
    lab.restore(truth)
    lab.advance(action)
    return lab.truth


def hits(lab: Parking, truth: Truth) -> bool:
    """Whether a car at this place crashes without acting, and the episode terminates."""
    lab.restore(truth)
    _, _, terminated, _, info = lab.advance((0.0, 0.0))
    return terminated and bool(info["crashed"])


def crashes(lab: Parking, truth: Truth, action: Action) -> bool:
    """Whether the car crashes in an action."""
    lab.restore(truth)
    return bool(lab.advance(action)[4]["crashed"])


# Claims about one turn share ways, so the last outcomes in each lab are kept.
_OUTCOMES: WeakKeyDictionary[Parking, dict[tuple[Truth, tuple[Action, ...]], int]] = WeakKeyDictionary()


def _outcome(lab: Parking, truth: Truth, actions: tuple[Action, ...]) -> int:
    """The number of actions that park the car in the simulator; 0 if they do not, or it crashes before."""
    known = _OUTCOMES.setdefault(lab, {})
    key = truth, actions
    if key not in known:
        if len(known) >= 16:
            known.clear()
        known[key] = _drive_out(lab, truth, actions)
    return known[key]


def _drive_out(lab: Parking, truth: Truth, actions: tuple[Action, ...]) -> int:
    lab.restore(truth)
    for count, action in enumerate(actions, 1):
        _, _, over, _, info = lab.advance(action)
        if over:
            return count if info["success"] else 0
    return 0


def parks(lab: Parking, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the last of the actions parks the car, and none before."""
    return bool(actions) and _outcome(lab, truth, actions) == len(actions)


def fails(lab: Parking, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the car is not parked by any of the actions."""
    return not _outcome(lab, truth, actions)


def stops(lab: Parking, truth: Truth, wheels: Sequence[float] = BRAKES) -> bool:
    """Whether the car stops without a crash by full braking with the wheel in one of these positions."""
    for wheel in wheels:
        lab.restore(truth)
        car = truth.car
        while not car.crashed and (car.impact or abs(car.speed) > 0.05):
            lab.advance((round(min(max(-car.speed, -1.0), 1.0), 2), wheel))
            car = lab.truth.car
        if not car.crashed:
            return True
    return False


def dooms(lab: Parking, truth: Truth, action: Action) -> bool:
    """Whether full braking prevents a crash now but not after an action, which is not a crash itself."""
    return not crashes(lab, truth, action) and stops(lab, truth) and not stops(lab, after_action(lab, truth, action))


def _without_cars(truth: Truth) -> Truth:
    """The truth with the other cars far from the car park and from each other."""
    return truth._replace(parked=tuple(other._replace(x=1e3 + 9 * i) for i, other in enumerate(truth.parked)))


def _whole(truth: Truth) -> Truth:
    """The truth with a car that has not crashed."""
    return truth._replace(car=truth.car._replace(impact=None, crashed=False))


def parks_within(lab: Parking, truth: Truth, spot: tuple[float, float, float], tolerance: float) -> bool:
    """Whether a car counts as parked exactly if its misfit is below the tolerance, in many poses near a spot."""
    x, y, goal = spot
    out = -math.copysign(1.0, y)  # away from the wall
    truth = _whole(truth)
    alone = _without_cars(truth)
    turns = (0.0, 0.1, -0.3, 0.5, math.pi)
    for dx, dy, turn in product((0.0, 0.4, -0.9, 1.3, 1.5), (0.0, 1.0, 2.5, 4.0, 4.9), turns):
        car = truth.car._replace(x=x + dx, y=y + out * dy, heading=goal + turn, speed=0.0)
        cosine, sine = math.cos(car.heading) - math.cos(goal), math.sin(car.heading) - math.sin(goal)
        off = abs(dx) + 0.3 * abs(dy) + 2 * abs(cosine) + 2 * abs(sine)
        lab.restore(alone._replace(car=car))
        if lab.advance((0.0, 0.0))[4]["is_success"] != (off < tolerance):
            return False
    return True


def stands_at(lab: Parking, truth: Truth, wall_x: float, wall_y: float) -> bool:
    """Whether a car crashes if it overlaps walls at these coordinates, not just before them, and in other cars."""
    x, y = wall_x - LENGTH / 2, wall_y - LENGTH / 2
    truth = _whole(truth)
    alone = _without_cars(truth)
    for side, turn in product((1, -1), (0.0, math.pi)):
        for along, crash in ((-0.01, False), (0.01, True)):
            across = truth.car._replace(x=side * (x + along), y=0.0, heading=turn, speed=0.0)
            down = truth.car._replace(x=0.0, y=side * (y + along), heading=turn + math.pi / 2, speed=0.0)
            if hits(lab, alone._replace(car=across)) != crash or hits(lab, alone._replace(car=down)) != crash:
                return False
    return all(hits(lab, truth._replace(car=truth.car._replace(x=c.x, y=c.y))) for c in truth.parked)


def obeys(lab: Parking, truth: Truth, seconds: float, acceleration: float, angle: float) -> bool:
    """Whether actions last for this time, with an acceleration and a wheel angle in proportion to their two numbers.

    Args:
        lab: the simulator.
        truth: a truth whose car may be replaced.
        seconds: duration of an action.
        acceleration: the acceleration for the number 1, in m/s2.
        angle: the wheel angle for the number 1, in radians.
    """
    truth = _whole(truth)
    middle = truth.car._replace(x=0.0, y=0.0, heading=0.0, speed=0.0)
    for share in (-1.0, -0.5, 0.5, 1.0):
        after = after_action(lab, truth._replace(car=middle), (share, 0.0))
        if not math.isclose(after.car.speed, share * acceleration * seconds, rel_tol=1e-6):
            return False
        if not math.isclose(after.time - truth.time, seconds, rel_tol=1e-6):
            return False
        rolled = after_action(lab, truth._replace(car=middle._replace(speed=1.0)), (0.0, share)).car.heading
        slip = math.atan(math.tan(share * angle) / 2)
        if not math.isclose(rolled, seconds * math.sin(slip) / (LENGTH / 2), rel_tol=1e-5):
            return False
    return True


def distance_to_spot(truth: Truth) -> float:
    """Distance between the middles of the car and the spot, in metres."""
    return math.hypot(truth.car.x - truth.spot.x, truth.car.y - truth.spot.y)


def write(action: Action) -> str:
    """An action as text."""
    return f"[{action[0]!r}, {action[1]!r}]"


def effort_of(count: int) -> str:
    """A number of actions as text."""
    return "1 action" if count == 1 else f"{count} actions"


def pedal_words(action: Action) -> str:
    """The pedals of an action, one of `PEDALS`."""
    return PEDALS[1 + (action[0] > 0) - (action[0] < 0)]


def wheel_words(action: Action) -> str:
    """The wheel of an action, one of `WHEELS`."""
    return WHEELS[1 + (action[1] > 0) - (action[1] < 0)]


def opposites(action: Action) -> tuple[Action, ...]:
    """Plausible actions that are very different from this one."""
    pedal, wheel = (-1.0 if share > 0 else 1.0 for share in action)
    return (pedal, wheel), (pedal, action[1]), (0.0, 0.0)


def turn_to_spot(lab: Parking, truth: Truth) -> float:
    """The turn from the car's heading to the spot's, by the observation, -180 to 180 degrees."""
    lab.restore(truth)
    seen = lab.observe()
    (cos, sin), (wanted_cos, wanted_sin) = (seen[part][-2:].tolist() for part in ("observation", "desired_goal"))
    return math.degrees(math.atan2(wanted_sin * cos - wanted_cos * sin, wanted_cos * cos + wanted_sin * sin))


def leads_in(lab: Parking, truth: Truth, pose: tuple[float, float, float]) -> bool:
    """Whether a car in this pose parks by driving straight ahead."""
    x, y, heading = pose
    if not all(map(math.isfinite, pose)):
        return False
    truth = _whole(truth)
    there = truth._replace(car=truth.car._replace(x=x, y=y, heading=heading, speed=0.0))
    return _drive_out(lab, there, ((0.5, 0.0),) * _STRAIGHT) > 0


_STRAIGHT = 20  # actions, which lead 20 m far
