"""Necessary conditions of success: distances that are quick to check, since most steps are far from success.

Without them a turn takes a fifth longer.
"""

from typing import NamedTuple


class Nearness(NamedTuple):
    """A necessary condition of metaworld's success: the distance of a point to the target."""

    radius: float
    """Greatest distance along each axis, in metres."""
    axes: tuple[int, ...] = (0, 1, 2)
    at: int = 0
    """Index of the point in `_get_pos_objects`: 0 is the first object, 3 the second; or `FINGERS`, their middle."""


FINGERS = -1
_X, _Y, _Z = (0,), (1,), (2,)
_SLACK = 1e-6  # metres: more than rounding, less than matters
_NEARNESS = {
    "basketball-v3": Nearness(0.08, (0, 1)),
    "box-close-v3": Nearness(0.08),
    "button-press-topdown-v3": Nearness(0.024, _Z),
    "button-press-topdown-wall-v3": Nearness(0.024, _Z),
    "button-press-v3": Nearness(0.02, _Y),
    "button-press-wall-v3": Nearness(0.03, _Y),
    "coffee-button-v3": Nearness(0.02, _Y),
    "coffee-pull-v3": Nearness(0.07),
    "coffee-push-v3": Nearness(0.07),
    "dial-turn-v3": Nearness(0.07),
    "door-close-v3": Nearness(0.08),
    "door-lock-v3": Nearness(0.02, _Z),
    "door-open-v3": Nearness(0.08, _X),
    "door-unlock-v3": Nearness(0.02, _X),
    "drawer-close-v3": Nearness(0.065),
    "drawer-open-v3": Nearness(0.03),
    "faucet-close-v3": Nearness(0.07),
    "faucet-open-v3": Nearness(0.11),  # 7 cm from a place on the handle
    "hand-insert-v3": Nearness(0.05),
    "handle-press-side-v3": Nearness(0.02, _Z),
    "handle-press-v3": Nearness(0.02, _Z),
    "handle-pull-side-v3": Nearness(0.08),
    "handle-pull-v3": Nearness(0.05, _Z),
    "peg-unplug-side-v3": Nearness(0.07),
    "pick-out-of-hole-v3": Nearness(0.07),
    "pick-place-v3": Nearness(0.07),
    "pick-place-wall-v3": Nearness(0.07),
    "plate-slide-back-side-v3": Nearness(0.07),
    "plate-slide-back-v3": Nearness(0.07),
    "plate-slide-side-v3": Nearness(0.07),
    "plate-slide-v3": Nearness(0.07),
    "push-back-v3": Nearness(0.07),
    "push-v3": Nearness(0.05),
    "push-wall-v3": Nearness(0.07),
    "reach-v3": Nearness(0.05, at=FINGERS),
    "reach-wall-v3": Nearness(0.05, at=FINGERS),
    "shelf-place-v3": Nearness(0.07),
    "soccer-v3": Nearness(0.07),
    "stick-pull-v3": Nearness(0.12, at=3),
    "stick-push-v3": Nearness(0.12, at=3),
    "sweep-into-v3": Nearness(0.05, (0, 1)),
    "sweep-v3": Nearness(0.05),
    "window-close-v3": Nearness(0.05, _X),
    "window-open-v3": Nearness(0.05, _X),
}
"""By task; for other tasks, success depends on something else or on earlier calls."""


def nearness_of(task: str) -> Nearness | None:
    """The condition of a task, with a margin for rounding; None if metaworld has to evaluate every step."""
    near = _NEARNESS.get(task)
    return near and near._replace(radius=near.radius + _SLACK)
