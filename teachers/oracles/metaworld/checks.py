"""What the claims about the hand are checked by: where it is, where it is wanted, and the words for both."""

import math
from collections.abc import Sequence

from teachers.atoms import Moment
from teachers.oracles.metaworld.corrections import correction_for
from worlds.metaworld import REACH, Aim, MetaWorld, Pose, Truth

Place = tuple[float, float, float]
Errors = tuple[int, int, int]
"""How far off a place is along x, y and z, in whole centimetres; 0 where it is right enough."""
AXES = ("x", "y", "z")
NOTABLE = 1.0
"""Centimetres that are worth mentioning."""
CLOSE = 1e-5
"""What two numbers that are the same may differ by, in metres or as grips: metaworld's commands are float32."""
_PLACE, _GRIP = 0.03, 0.3  # how far from what is wanted is right enough


def hand_of(truth: Truth) -> Place:
    """Where the hand is."""
    x, y, z = truth.observation[:3]
    return x, y, z


def origin_of(world: MetaWorld) -> str:
    """From where x, y and z count, in words."""
    return "from where the hand is" if world.relative else "from a fixed point of the table"


def reach_of(truth: Truth, world: MetaWorld) -> tuple[Place, Place]:
    """The smallest and the largest place that an action can name."""
    low, high = (world.target(truth, (bound, bound, bound, 0.0)) for bound in (-REACH, REACH))
    return low, high


def rounded(pose: Sequence[float]) -> Pose:
    """To two decimals, within the action space."""
    x, y, z, grip = (round(number, 2) + 0.0 for number in pose)
    x, y, z = (min(max(number, -REACH), REACH) for number in (x, y, z))
    return x, y, z, min(max(grip, -1.0), 1.0)


def write_number(number: float) -> str:
    """A coordinate, to a millimetre, or a grip; advice has no more than two decimals."""
    return f"{round(number, 3) + 0.0:g}"


def write(pose: Sequence[float]) -> str:
    """Coordinates, and the grip if there is one."""
    return f"[{', '.join(map(write_number, pose))}]"


def write_compactly(pose: Pose) -> str:
    """As `write`, without spaces."""
    return write(pose).replace(" ", "")


def action_for(aim: Aim, truth: Truth, world: MetaWorld) -> Pose:
    """The action that aims as the policy does."""
    place = aim.target
    if world.relative:
        x, y, z = hand_of(truth)
        place = place[0] - x, place[1] - y, place[2] - z
    return rounded((*place, aim.grip))


def commanded(truth: Truth, lab: MetaWorld) -> tuple[Place, float]:
    """What is wanted, from the command that the policy itself would send: the hand, and the command over the gain."""
    correction = correction_for(lab)
    seen, hand = correction.seen(truth), hand_of(truth)
    x, y, z, grip = lab.script.command(seen).tolist()
    gain = lab.script.aim(seen).gain
    aim = Aim((hand[0] + x / gain, hand[1] + y / gain, hand[2] + z / gain), gain, grip)
    wanted = correction.applied(aim, truth)
    return wanted.target, wanted.grip


def off_by(place: Place, wanted: Place) -> Errors:
    """Per axis by how much a place is too large, or, below 0, too small."""
    x, y, z = (round(100 * (a - w)) if abs(a - w) > _PLACE else 0 for a, w in zip(place, wanted, strict=True))
    return x, y, z


def tell(errors: Errors) -> str:
    """Errors in words."""
    parts = [
        f"{axis} {abs(error)} cm too {'large' if error > 0 else 'small'}"
        for axis, error in zip(AXES, errors, strict=True)
        if error
    ]
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if parts[1:] else parts).replace(" ", " was ", 1)


def directions(hand: Place, place: Place, slack: float = 0.0) -> tuple[str, ...]:
    """The axes along which there are more than 2 cm, each with its sign."""
    return tuple(
        f"{'+' if b > a else '-'}{axis}"
        for axis, a, b in zip(AXES, hand, place, strict=True)
        if abs(a - b) > 0.02 + slack
    )


def slip_of(excess: float) -> int:
    """-1 if a grip is too small, 1 if it is too large, 0 if it is right enough."""
    return (excess > _GRIP) - (excess < -_GRIP)


def apart(hand: Place, place: Place) -> float:
    """Centimetres, to a millimetre."""
    return round(100 * math.dist(hand, place), 1)


def succeeds(lab: MetaWorld, truth: Truth, action: Pose) -> bool:
    """Whether an action solves the task."""
    lab.restore(truth)
    return bool(lab.advance(action)[4]["success"])


def goes(lab: MetaWorld, truth: Truth, action: Pose, before: float, after: float) -> bool:
    """Whether an action takes the hand from `before` to `after` centimetres from where it is wanted, notably so.

    The rounding of a command may have changed the last digit.
    """
    if abs(after - before) < NOTABLE:
        return False
    place, _ = commanded(truth, lab)
    lab.restore(truth)
    lab.advance(action)
    ends = apart(hand_of(truth), place), apart(hand_of(lab.truth), place)
    return abs(before - ends[0]) < 0.15 and abs(after - ends[1]) < 0.15


def misplaced(lab: MetaWorld, moment: Moment[Truth], errors: Errors) -> bool:
    """Whether the place of the moment's action was off by so much, and no axis else by what matters."""
    place, wanted = lab.target(moment.past, moment.action), commanded(moment.past, lab)[0]
    return all(
        abs(a - w) > _PLACE - CLOSE and abs(a - w - error / 100) <= 0.005 + CLOSE
        if error
        else abs(a - w) <= _PLACE + CLOSE
        for a, w, error in zip(place, wanted, errors, strict=True)
    )


def slipped(lab: MetaWorld, moment: Moment[Truth], side: int) -> bool:
    """Whether the grip of the moment's action was right enough, if `side` is 0; else too far to this side."""
    excess: float = moment.action[3] - commanded(moment.past, lab)[1]
    return side * excess > _GRIP - CLOSE if side else abs(excess) <= _GRIP + CLOSE
