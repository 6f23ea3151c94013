"""Corrections of metaworld's scripted policies for actions that last a turn instead of one low-level step."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from worlds.metaworld import Aim, MetaWorld, Truth

_OPEN = 0.9
"""So far open at least is a gripper that has not begun to close."""
_NEAR = 0.04
"""Metres within which a hand has come down to what it is to grasp, and beyond which aside it still travels."""


def _moved(place: Sequence[float], by: Sequence[float]) -> tuple[float, ...]:
    return tuple([a + b for a, b in zip(place, by, strict=True)])


@dataclass(frozen=True, kw_only=True)
class Correction:
    """What a policy's aim is changed to. The policy may do two things at once and change its mind at every low-level
    step; a turn is longer than that.
    """  # noqa: D205

    opening: float | None = None
    """The policy's largest grip that does not take hold; the gripper is then opened wide. What takes hold comes in
    turns of their own: the hand goes down, closes where it is, and only then carries. None: nothing is grasped."""
    stride: float | None = None
    """So far from where it is, in metres along an axis, the hand is sent at most."""
    travel: float | None = None
    """The height at which an open hand goes to what it is to grasp."""
    nudge: tuple[float, float, float] | None = None
    """The policy is asked as if the first object were so far from where it is."""
    beyond: tuple[float, float, float] | None = None
    """The policy is asked as if the goal were so far from where it is."""

    def seen(self, truth: Truth) -> tuple[float, ...]:
        """The observation that the policy is asked with."""
        numbers = truth.observation
        if self.nudge is not None:
            numbers = *numbers[:4], *_moved(numbers[4:7], self.nudge), *numbers[7:]
        return numbers if self.beyond is None else (*numbers[:36], *_moved(numbers[36:], self.beyond))

    def applied(self, aim: Aim, truth: Truth) -> Aim:
        """What is aimed at instead of what the policy aims at."""
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
"""By task. Where the policy alone solves a task as reliably, it is left as it is."""
_NONE = Correction()


def correction_for(world: MetaWorld) -> Correction:
    """That of the world's task. With `teacher_event` a turn ends when the policy changes its mind, so it needs none."""
    return _NONE if world.options["control"] == "teacher_event" else CORRECTIONS.get(world.task, _NONE)


def aim_of(world: MetaWorld, truth: Truth) -> Aim:
    """Where the hand is wanted: what the scripted policy aims at, corrected."""
    correction = correction_for(world)
    return correction.applied(world.script.aim(correction.seen(truth)), truth)
