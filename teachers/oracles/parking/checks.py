"""What the claims about parking are checked by: drives in the simulator, and the words for actions."""

import math
from weakref import WeakKeyDictionary

from teachers.oracles.parking.driving import BRAKES
from worlds.parking import Action, Truth
from worlds.world import World

PEDALS = ("push backwards", "leave the pedals alone", "push forwards")
"""What can be done to the pedals, in words."""
WHEELS = ("turn the wheel to the left", "hold the wheel straight", "turn the wheel to the right")
"""What can be done to the wheel, in words."""


def after_action(lab: World, truth: Truth, action: Action) -> Truth:
    """The truth after an action in the simulator."""
    lab.restore(truth)
    lab.advance(action)
    return lab.truth


def hits(lab: World, truth: Truth) -> bool:
    """Whether a car that waits crashes, and the episode ends by it."""
    lab.restore(truth)
    _, _, terminated, _, info = lab.advance((0.0, 0.0))
    return terminated and info["crashed"]


def crashes(lab: World, truth: Truth, action: Action) -> bool:
    """Whether the car crashes in an action."""
    lab.restore(truth)
    return lab.advance(action)[4]["crashed"]


# Claims about one turn share ways, so the last outcomes in each lab are kept.
_OUTCOMES: WeakKeyDictionary[World, dict[tuple[Truth, tuple[Action, ...]], int]] = WeakKeyDictionary()


def _outcome(lab: World, truth: Truth, actions: tuple[Action, ...]) -> int:
    """After how many of the actions the simulator says that the car is parked; 0 if it is not, or crashes before."""
    known = _OUTCOMES.setdefault(lab, {})
    key = truth, actions
    if key not in known:
        if len(known) >= 16:
            known.clear()
        known[key] = _drive_out(lab, truth, actions)
    return known[key]


def _drive_out(lab: World, truth: Truth, actions: tuple[Action, ...]) -> int:
    lab.restore(truth)
    for count, action in enumerate(actions, 1):
        _, _, over, _, info = lab.advance(action)
        if over:
            return count if info["success"] else 0
    return 0


def parks(lab: World, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the last of the actions parks the car, and none before."""
    return bool(actions) and _outcome(lab, truth, actions) == len(actions)


def fails(lab: World, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the car is not parked by any of the actions."""
    return not _outcome(lab, truth, actions)


def stops(lab: World, truth: Truth) -> bool:
    """Whether the car comes to a halt without a crash by full braking with one of the `BRAKES`."""
    for wheel in BRAKES:
        lab.restore(truth)
        car = truth.car
        while not car.crashed and (car.impact or abs(car.speed) > 0.05):
            lab.advance((round(min(max(-car.speed, -1.0), 1.0), 2), wheel))
            car = lab.truth.car
        if not car.crashed:
            return True
    return False


def distance_to_spot(truth: Truth) -> float:
    """From the middle of the car to that of the spot, in metres."""
    return math.hypot(truth.car.x - truth.spot.x, truth.car.y - truth.spot.y)


def write(action: Action) -> str:
    """An action as text."""
    return f"[{action[0]!r}, {action[1]!r}]"


def effort_of(count: int) -> str:
    """A number of actions in words."""
    return "1 action" if count == 1 else f"{count} actions"


def pedal_words(action: Action) -> str:
    """What an action does to the pedals, one of `PEDALS`."""
    return PEDALS[1 + (action[0] > 0) - (action[0] < 0)]


def wheel_words(action: Action) -> str:
    """What an action does to the wheel, one of `WHEELS`."""
    return WHEELS[1 + (action[1] > 0) - (action[1] < 0)]
