"""The claims about driving the hand, each checked in a copy of the simulator or by the policy's command.

The script is metaworld's scripted policy, corrected; it wants the hand at its aim. Nobody knows whether another target
is as good, so verdicts on a target only say whether it agrees with the script.
"""

import math
from collections.abc import Sequence
from typing import Annotated, ClassVar

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Moment, PlanClaim, Scope, claim, opposed, slot
from teachers.common import ChangeVerdict, TryAgain
from teachers.oracles.metaworld.corrections import aim_of, correction_for
from teachers.oracles.metaworld.purposes import PURPOSES, USES
from worlds.metaworld import REACH, Aim, MetaWorld, Pose, Truth

Place = tuple[float, float, float]
Errors = tuple[int, int, int]
"""Errors of a place along x, y and z, in whole centimetres; 0 within the tolerance."""
AXES = ("x", "y", "z")
SIGNED = ("+x", "-x", "+y", "-y", "+z", "-z")
"""The signed axes."""
NOTABLE = 1.0
"""The smallest change of distance that verdicts judge, in centimetres."""
CLOSE = 1e-5
"""Tolerance for equal numbers, in metres or units of grip: metaworld's commands are float32."""
_PLACE, _GRIP = 0.03, 0.3  # how far from what is wanted is right enough


def hand_of(truth: Truth) -> Place:
    """The position of the hand."""
    x, y, z = truth.observation[:3]
    return x, y, z


def origin_of(world: MetaWorld) -> str:
    """The origin of x, y and z, in words."""
    return "from where the hand is" if world.relative else "from a fixed point of the table"


def reach_of(truth: Truth, world: MetaWorld) -> tuple[Place, Place]:
    """The lowest and the highest corner of the places that an action can name."""
    low, high = (world.target(truth, (bound, bound, bound, 0.0)) for bound in (-REACH, REACH))
    return low, high


def rounded(pose: Sequence[float]) -> Pose:
    """Round a pose to two decimals, within the action space."""
    x, y, z, grip = (round(number, 2) + 0.0 for number in pose)
    x, y, z = (min(max(number, -REACH), REACH) for number in (x, y, z))
    return x, y, z, min(max(grip, -1.0), 1.0)


def format_number(number: float) -> str:
    """A coordinate, to a millimetre, or a grip as text; advice has at most two decimals."""
    return f"{round(number, 3) + 0.0:g}"


def format_numbers(pose: Sequence[float]) -> str:
    """Coordinates, and the grip if there is one, as text."""
    return f"[{', '.join(map(format_number, pose))}]"


def format_compactly(pose: Pose) -> str:
    """`format_numbers` without spaces."""
    return format_numbers(pose).replace(" ", "")


def action_for(aim: Aim, truth: Truth, world: MetaWorld) -> Pose:
    """The action with this aim."""
    place = aim.target
    if world.relative:
        x, y, z = hand_of(truth)
        place = place[0] - x, place[1] - y, place[2] - z
    return rounded((*place, aim.grip))


def commanded(truth: Truth, lab: MetaWorld) -> tuple[Place, float]:
    """The aim by the policy's own command: the hand's position plus the command over the gain."""
    correction = correction_for(lab)
    seen, hand = correction.seen(truth), hand_of(truth)
    x, y, z, grip = lab.script.command(seen).tolist()
    gain = lab.script.aim(seen).gain
    aim = Aim((hand[0] + x / gain, hand[1] + y / gain, hand[2] + z / gain), gain, grip)
    wanted = correction.applied(aim, truth)
    return wanted.target, wanted.grip


def off_by(place: Place, wanted: Place) -> Errors:
    """The signed error of a place along each axis."""
    x, y, z = (round(100 * (a - w)) if abs(a - w) > _PLACE else 0 for a, w in zip(place, wanted, strict=True))
    return x, y, z


def format_errors(errors: Errors) -> str:
    """Errors in words."""
    parts = [
        f"{axis} {abs(error)} cm too {'large' if error > 0 else 'small'}"
        for axis, error in zip(AXES, errors, strict=True)
        if error
    ]
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if parts[1:] else parts).replace(" ", " was ", 1)


def directions(hand: Place, place: Place, slack: float = 0.0) -> tuple[str, ...]:
    """The axes with a distance of more than 2 cm, each with its sign."""
    return tuple(
        f"{'+' if b > a else '-'}{axis}"
        for axis, a, b in zip(AXES, hand, place, strict=True)
        if abs(a - b) > 0.02 + slack
    )


def slip_of(excess: float) -> int:
    """-1 if a grip is too small, 1 if it is too large, 0 within the tolerance."""
    return (excess > _GRIP) - (excess < -_GRIP)


def apart(hand: Place, place: Place) -> float:
    """Distance in centimetres, to a millimetre."""
    return round(100 * math.dist(hand, place), 1)


def succeeds(lab: MetaWorld, truth: Truth, action: Pose) -> bool:
    """Whether an action solves the task."""
    lab.restore(truth)
    return bool(lab.advance(lab.legal(action))[4]["success"])


def goes(lab: MetaWorld, truth: Truth, action: Pose, before: float, after: float) -> bool:
    """Whether an action changes the hand's distance from the aim from `before` to `after` cm, by at least `NOTABLE`.

    The rounding of a command may change the last digit.
    """
    if abs(after - before) < NOTABLE:
        return False
    place, _ = commanded(truth, lab)
    lab.restore(truth)
    lab.advance(lab.legal(action))
    ends = apart(hand_of(truth), place), apart(hand_of(lab.truth), place)
    return abs(before - ends[0]) < 0.15 and abs(after - ends[1]) < 0.15


def misplaced(lab: MetaWorld, moment: Moment[Truth], errors: Errors) -> bool:
    """Whether the errors of the place of the moment's action are `errors`, and within the tolerance elsewhere."""
    place, wanted = lab.target(moment.past, moment.action), commanded(moment.past, lab)[0]
    return all(
        abs(a - w) > _PLACE - CLOSE and abs(a - w - error / 100) <= 0.005 + CLOSE
        if error
        else abs(a - w) <= _PLACE + CLOSE
        for a, w, error in zip(place, wanted, errors, strict=True)
    )


def slipped(lab: MetaWorld, moment: Moment[Truth], side: int) -> bool:
    """Whether the grip of the moment's action was within the tolerance (`side` 0), or wrong to this side."""
    excess: float = moment.action[3] - commanded(moment.past, lab)[1]
    return side * excess > _GRIP - CLOSE if side else abs(excess) <= _GRIP + CLOSE


@claim
class Goal(Claim[Truth, MetaWorld]):
    """True if `purpose` says what solves the task."""

    task: str
    purpose = slot(PURPOSES.__getitem__, "task")

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Look the task up."""
        return self.task == lab.task


@claim
class Driving(Claim[Truth, MetaWorld]):
    """True if an action drives the hand towards its target for at most `most` small steps, z counts upwards, and the
    gripper opens at -1 and closes at 1.
    """  # noqa: D205

    origin: str
    """The origin of x, y and z, in words."""
    most: int

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Go up with an open and with a closed gripper."""
        if (self.origin, self.most) != (origin_of(lab), lab.longest):
            return False
        x, y, z = hand_of(moment.after)
        heights, openings = [], []
        for grip in (-1.0, 1.0):
            lab.restore(moment.after)
            for _ in range(3):
                lab.advance((0.0, 0.0, 0.05, grip) if lab.relative else (x, y, z + 0.05, grip))
                heights.append(lab.truth.observation[2] - z)
            openings.append(lab.truth.observation[3])
        return min(heights) > 0 and openings[0] > openings[1]


class _Posed(ActionClaim[Truth, MetaWorld]):
    """Base of claims whose phrases name the target."""

    __slots__ = ()
    action_slot = "target"
    action: Pose
    target = slot(format_numbers, "action")


@claim
class _Moved(ChangeVerdict[Truth, MetaWorld]):
    """Base of verdicts on the hand's distance from where the script wants it."""

    before: float
    """Centimetres."""
    after: float

    def applies(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Take the action again and measure."""
        return _open(moment) and goes(lab, moment.past, moment.action, self.before, self.after)


@claim
class _Tried(_Moved, _Posed):
    """Base of verdicts on an action that the oracle tried at the start."""

    tried = True
    action: Pose

    def applies(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Try it."""
        return goes(lab, moment.after, self.action, self.before, self.after)


@claim
class TriedWell(_Tried):
    """True if `action` first takes the hand 1 cm or more nearer to the script's place: from `before` to `after` cm."""

    kind = HP


@claim
class TriedInVain(_Tried):
    """True if `action` first takes the hand 1 cm or more away from the script's place: from `before` to `after` cm."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Solution(PlanClaim[Truth, MetaWorld]):
    """True if these actions, in order, solve the task with the last one and not before."""

    actions: tuple[Pose, ...]
    count = slot(len, "actions")

    @property
    def listing(self) -> str:
        """The actions as text."""
        return self.separator.join(map(format_compactly, self.actions))

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Play them."""
        lab.restore(moment.after)
        success = [lab.advance(lab.legal(action))[4]["success"] for action in self.actions]
        return success.count(True) == 1 and bool(success[-1])


@claim
class _Judged(_Posed):
    """Base of verdicts on a target. Phrases round it to a millimetre, so they may not state the exact action."""

    action_slot = ""
    action: Pose

    def about(self, moment: Moment[Truth]) -> bool:
        """Whether the action was taken, and the task not solved before."""
        return _open(moment) and moment.action == self.action


@claim
class Done(_Judged):
    """True if this action solved the task, which was not solved before."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Take the action again."""
        return self.about(moment) and succeeds(lab, moment.past, self.action)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Deny it."""
        return (TryAgain(),)


@claim
class WellAimed(_Judged):
    """True if the target was within 3 cm along each axis of the place where the script wanted the hand, and the grip
    within 0.3 of the one that it wanted, when the action was chosen.
    """  # noqa: D205

    kind = HP

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Ask metaworld's policy for its command."""
        return self.about(moment) and misplaced(lab, moment, _RIGHT) and slipped(lab, moment, 0)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Find fault."""
        return (Off(action=self.action, errors=(10, 0, 0)),)


@claim
class RightPlace(Claim[Truth, MetaWorld]):
    """True if the target's place was within 3 cm along each axis of the script's; nothing on the grip."""

    kind = HP
    at: Place
    """The target's place, relative to the hand where actions are."""
    place = slot(format_numbers, "at")

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Ask metaworld's policy for its command."""
        return _open(moment) and self.at == moment.action[:3] and misplaced(lab, moment, _RIGHT)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Find fault."""
        return (Off(action=moment.action, errors=(0, 0, -10)),)


@claim
class RightGrip(Claim[Truth, MetaWorld]):
    """True if the grip was within 0.3 of the one that the script wanted; nothing on the place."""

    kind = HP
    value: float
    """The grip that was taken."""
    grip = slot(format_number, "value")

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Ask metaworld's policy for its command."""
        return _open(moment) and self.value == moment.action[3] and slipped(lab, moment, 0)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Find fault."""
        return (TooTight(action=moment.action),)


@claim
class Neared(_Moved):
    """True if the action took the hand 1 cm or more nearer to the script's place: from `before` to `after` cm."""

    kind = HP


@claim
class Strayed(_Moved):
    """True if the action took the hand 1 cm or more away from the script's place: from `before` to `after` cm."""

    kind = HN


opposed(Neared, Strayed)


@claim
class Off(_Judged):
    """True if the target's place was off the script's by more than 3 cm along the named axes, so far, and no others."""

    kind = HN
    errors: Errors
    faults = slot(format_errors, "errors")

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Ask metaworld's policy for its command."""
        return self.about(moment) and self.errors != _RIGHT and misplaced(lab, moment, self.errors)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Praise it."""
        return (WellAimed(action=self.action), RightPlace(at=self.action[:3]))


@claim
class _Slip(_Judged):
    """Base of blame for the grip."""

    side: ClassVar[int]
    """-1 for a grip that is too small, 1 for one that is too large."""

    @property
    def grip(self) -> str:
        """The grip as text."""
        return format_number(self.action[3])

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Ask metaworld's policy for its command."""
        return self.about(moment) and slipped(lab, moment, self.side)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Praise it."""
        return (RightGrip(value=self.action[3]),)


@claim
class TooLoose(_Slip):
    """True if the script would have closed the gripper more: the grip was smaller than its own by more than 0.3."""

    kind = HN
    side = -1


@claim
class TooTight(_Slip):
    """True if the script would have opened the gripper more: the grip was larger than its own by more than 0.3."""

    kind = HN
    side = 1


@claim
class Aiming(_Posed):
    """True if `action` is, to two decimals, the pose that metaworld's scripted policy, corrected, aims at now."""

    kind = FP
    action: Pose

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Compute the pose from the policy's command and gain, clipped to the reach."""
        truth = moment.after
        place, grip = commanded(truth, lab)
        wanted = [min(max(w, a), b) for w, a, b in zip(place, *reach_of(truth, lab), strict=True)]
        pairs = zip((*lab.target(truth, self.action), self.action[3]), (*wanted, grip), strict=True)
        return not truth.solved and all(abs(a - w) <= _ROUNDING for a, w in pairs)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Send the hand the other way, or elsewhere, with the other grip."""
        truth, (x, y, z, grip) = moment.after, self.action
        hand = (0.0, 0.0, 0.0) if lab.relative else hand_of(truth)
        mirrored = rounded((2 * hand[0] - x, 2 * hand[1] - y, 2 * hand[2] - z, -grip))
        elsewhere = rounded((x + 0.2, y, z, grip))
        return tuple(Aiming(action=action) for action in (mirrored, elsewhere))

    def coarser(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """The distance, then the direction."""
        hand, at = hand_of(moment.after), lab.target(moment.after, self.action)
        far = Distance(centimetres=round(100 * math.dist(hand, at)))
        axes = directions(hand, at)
        return (far, Heading(axes=axes)) if axes else (far,)


@claim
class Distance(Claim[Truth, MetaWorld]):
    """True if the place where the script wants the hand now is so far from it, to a centimetre or so."""

    kind = FP
    centimetres: int

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Compute the place from the policy's command and gain."""
        apart = 100 * math.dist(hand_of(moment.after), commanded(moment.after, lab)[0])
        return not moment.after.solved and abs(apart - self.centimetres) <= 2

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Claim another distance."""
        return (Distance(centimetres=self.centimetres + 15),)


@claim
class Heading(Claim[Truth, MetaWorld]):
    """True if the script wants the hand in this direction: along each named axis by more than 2 cm, give or take 1."""

    kind = FP
    axes: tuple[Annotated[str, SIGNED], ...]
    """Each with its sign, such as `+x`."""
    ways = slot(" and ".join, "axes")

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Compute the place from the policy's command and gain."""
        truth = moment.after
        place, _ = commanded(truth, lab)
        sure, possible = (set(directions(hand_of(truth), place, slack)) for slack in (0.01, -0.01))
        return not truth.solved and sure <= set(self.axes) <= possible

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """The opposite direction."""
        return (Heading(axes=tuple(axis.translate(_OPPOSITE) for axis in self.axes)),)


@claim
class Avoid(_Posed):
    """True if `action` would take the hand 1 cm or more away from the script's place: from `before` to `after` cm."""

    kind = FN
    action: Pose
    before: float
    after: float

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Take the action in a copy of the simulator."""
        farther = not moment.after.solved and self.after > self.before
        return farther and goes(lab, moment.after, self.action, self.before, self.after)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Warn of the aim, as if it led away."""
        action = action_for(aim_of(lab, moment.after), moment.after, lab)
        return (Avoid(action=action, before=self.before, after=self.after),)


@claim
class Grips(Claim[Truth, MetaWorld]):
    """True if, in one play of this task, the script uses the gripper as `use` says.

    It is `hold` if the gripper closes only after the hand has come near, and `shut` if it is closed from the start on.
    """

    kind = FP
    scope = Scope.WORLD
    use: Annotated[str, (*USES,)]
    advice = slot(USES.__getitem__, "use")
    counterparts = Claim.varied("use", USES)

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Let the script play the task."""
        return self.use == _gripping(lab)


@claim
class NoGrip(Claim[Truth, MetaWorld]):
    """True if, in one play of this task, the script never closes the gripper."""

    kind = FN
    scope = Scope.WORLD

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Let the script play the task."""
        return _gripping(lab) == ""

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """Claim that the script closes it."""
        return tuple(Grips(use=use) for use in USES)

    def excludes(self, other: Claim) -> bool:
        """A claim that the script closes it."""
        return isinstance(other, Grips)


@claim
class Toward(Claim[Truth, MetaWorld]):
    """True if the script wants the hand on this side of where it is, by more than 2 cm, give or take 1."""

    kind = FP
    axis: Annotated[str, SIGNED]
    """The axis with its sign, such as `+x`."""

    def holds(self, moment: Moment[Truth], lab: MetaWorld) -> bool:
        """Compute the place from the policy's command and gain."""
        place, _ = commanded(moment.after, lab)
        return not moment.after.solved and self.axis in directions(hand_of(moment.after), place, -0.01)

    def counterparts(self, moment: Moment[Truth], lab: MetaWorld) -> Sequence[Claim]:
        """The opposite side."""
        return (Toward(axis=self.axis.translate(_OPPOSITE)),)

    def excludes(self, other: Claim) -> bool:
        """The opposite side."""
        return other == Toward(axis=self.axis.translate(_OPPOSITE))


_GRIPPING: dict[str, str] = {}


def _gripping(lab: MetaWorld) -> str:
    """The script's use of the gripper in a task, one of `USES`, by its commands; empty if the gripper stays open."""
    if lab.task not in _GRIPPING:
        lab.reset(seed=0)
        grips: list[bool] = []
        while len(grips) < _PLAYED and not (truth := lab.truth).solved:
            grips.append(commanded(truth, lab)[1] > _GRIP)
            lab.advance(action_for(aim_of(lab, truth), truth, lab))
        _GRIPPING[lab.task] = "" if not any(grips) else "shut" if grips[0] else "hold"
    return _GRIPPING[lab.task]


_PLAYED = 14  # turns
_RIGHT: Errors = (0, 0, 0)
_ROUNDING = 0.005 + CLOSE  # of advice
_OPPOSITE = str.maketrans({"+": "-", "-": "+"})


def _open(moment: Moment[Truth]) -> bool:
    return moment.before is not None and not moment.before.solved
