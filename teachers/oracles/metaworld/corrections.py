"""Corrections of metaworld's scripted policies for actions that last a turn instead of one low-level step."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from worlds.metaworld import Aim, MetaWorld, Truth

_OPEN = 0.9
"""Least opening of a gripper that has not begun to close."""
_NEAR = 0.04
"""Distance in metres: a hand this near above its object has come down; one farther off to the side still travels."""


def _moved(place: Sequence[float], by: Sequence[float]) -> tuple[float, ...]:
    return tuple([a + b for a, b in zip(place, by, strict=True)])


@dataclass(frozen=True, kw_only=True)
class Correction:
    """How to change a policy's aim. The policy may do two things at once and change its aim at every low-level step; a
    turn lasts many of these.
    """  # noqa: D205

    opening: float | None = None
    """The policy's largest grip that does not grasp; the gripper then opens wide. Grasping takes separate turns: the
    hand goes down, closes in place, and only then carries. None: the task needs no grasp."""
    stride: float | None = None
    """Longest move of the hand in one turn, in metres along an axis."""
    travel: float | None = None
    """The height at which an open hand travels to its object."""
    nudge: tuple[float, float, float] | None = None
    """Offset of the first object in the observation that the policy gets."""
    beyond: tuple[float, float, float] | None = None
    """Offset of the goal in the observation that the policy gets."""

    def seen(self, truth: Truth) -> tuple[float, ...]:
        """The observation that the policy gets."""
        numbers = truth.observation
        if self.nudge is not None:
            numbers = *numbers[:4], *_moved(numbers[4:7], self.nudge), *numbers[7:]
        return numbers if self.beyond is None else (*numbers[:36], *_moved(numbers[36:], self.beyond))

    def applied(self, aim: Aim, truth: Truth) -> Aim:
        """The corrected aim."""
        hand, gripper = truth.observation[:3], truth.observation[3]
        (x, y, z), grip = aim.target, aim.grip
        if self.opening is not None and grip <= self.opening:
            grip = -1.0
            if self.travel is not None and math.dist(hand[:2], (x, y)) > _NEAR:
                z = self.travel
        elif self.opening is not None and gripper > _OPEN:
            if z < hand[2] - _NEAR:
                grip = -1.0
            else:
                x, y, z = hand[0], hand[1], min(z, hand[2])
        if self.stride is not None:
            x, y, z = (min(max(a, h - self.stride), h + self.stride) for a, h in zip((x, y, z), hand, strict=True))
        return aim._replace(target=(x, y, z), grip=grip)


CORRECTIONS = {
    "basketball-v3": Correction(opening=0.0, travel=0.13),
    "box-close-v3": Correction(opening=0.5, stride=0.05),
    "button-press-wall-v3": Correction(nudge=(0.0, 0.02, 0.0)),
    "coffee-pull-v3": Correction(stride=0.05),
    "coffee-push-v3": Correction(opening=0.0),
    "disassemble-v3": Correction(opening=0.0, nudge=(0.0, 0.0, 0.01)),
    "handle-pull-side-v3": Correction(opening=0.0, stride=0.04),
    "lever-pull-v3": Correction(stride=0.02),
    "peg-insert-side-v3": Correction(opening=0.0),
    "peg-unplug-side-v3": Correction(stride=0.04),
    "pick-place-wall-v3": Correction(opening=0.0),
    "push-back-v3": Correction(opening=0.0),
    "push-v3": Correction(opening=0.0),
    "stick-pull-v3": Correction(opening=0.0, nudge=(0.0, 0.0, -0.01), beyond=(0.0, -0.03, 0.0)),
}
"""The corrections by task; tasks that the policy alone solves as reliably have none."""
_NONE = Correction()


def correction_for(world: MetaWorld) -> Correction:
    """The correction for the world's task. With `teacher_event` a turn ends when the policy changes its aim: none."""
    return _NONE if world.options["control"] == "teacher_event" else CORRECTIONS.get(world.task, _NONE)


def aim_of(world: MetaWorld, truth: Truth, stride: float | None = None) -> Aim:
    """The corrected aim of the scripted policy, with another stride if one is given."""
    correction = correction_for(world)
    correction = correction if stride is None else replace(correction, stride=stride)
    return correction.applied(world.script.aim(correction.seen(truth)), truth)
