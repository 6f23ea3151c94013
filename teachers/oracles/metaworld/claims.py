"""What is said about driving the hand, each measured in a copy of the simulator or by the policy's own command."""

import math
from collections.abc import Sequence

from teachers.atoms import FN, FP, HN, HP, Claim, Moment, claim
from teachers.common import TryAgain
from teachers.oracles.metaworld.checks import (
    AXES,
    NOTABLE,
    action_for,
    apart,
    commanded,
    directions,
    hand_of,
    off_by,
    origin_of,
    reach_of,
    rounded,
    slip_of,
    write,
    write_compactly,
)
from teachers.oracles.metaworld.purposes import PURPOSES
from worlds.metaworld import Pose, Truth
from worlds.world import World


@claim
class Goal(Claim):
    """True if `purpose` says what solves the task."""

    task: str
    purpose: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Look the task up."""
        return self.task == lab.task and self.purpose == PURPOSES[self.task]


@claim
class Driving(Claim):
    """True if an action drives the hand towards its target for at most `most` small steps, z counts upwards, and the
    gripper opens at -1 and closes at 1.
    """  # noqa: D205

    origin: str
    """From where x, y and z count."""
    most: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Go up with an open and with a closed gripper."""
        x, y, z = hand_of(moment.after)
        heights, openings = [], []
        for grip in (-1.0, 1.0):
            lab.restore(moment.after)
            for _ in range(3):
                lab.advance((0.0, 0.0, 0.05, grip) if lab.relative else (x, y, z + 0.05, grip))
                heights.append(lab.truth.observation[2] - z)
            openings.append(lab.truth.observation[3])
        return (
            min(heights) > 0
            and openings[0] > openings[1]
            and self.origin == origin_of(lab)
            and self.most == lab.longest
        )


@claim
class TriedWell(Claim):
    """True if `action` at the start takes the hand from `before` to `after` centimetres from where it is wanted, and
    that is nearer by at least 1 cm.
    """  # noqa: D205

    kind = HP
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it."""
        return _tried(self, moment.after, lab) and self.before - self.after >= NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, target=self.target, before=self.after, after=self.before),)


@claim
class TriedInVain(Claim):
    """True if `action` at the start takes the hand from `before` to `after` centimetres from where it is wanted, and
    that is farther away by at least 1 cm.
    """  # noqa: D205

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Try it."""
        return _tried(self, moment.after, lab) and self.after - self.before >= NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, target=self.target, before=self.after, after=self.before),)


@claim
class Solution(Claim):
    """True if these actions, in order, solve the task with the last one and not before."""

    actions: tuple[Pose, ...]
    listing: str
    count: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Play them."""
        lab.restore(moment.after)
        success = [lab.advance(action)[4]["success"] for action in self.actions]
        return success.index(True) + 1 == len(success) == self.count and self.listing == ", ".join(
            map(write_compactly, self.actions)
        )


@claim
class Done(Claim):
    """True if this action solved the task, which was not solved before."""

    kind = HP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again."""
        if not _judged(self, moment):
            return False
        lab.restore(moment.before)
        return lab.advance(self.action)[4]["success"]

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Deny it."""
        return (TryAgain(),)


@claim
class WellAimed(Claim):
    """True if the target was within 3 cm along each axis of the place where the hand was wanted, and the grip within
    0.3 of the one that was wanted, when the action was chosen.
    """  # noqa: D205

    kind = HP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and not _faults(self.action, moment.before, lab) and not _slip(moment, lab)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        return (Off(action=self.action, target=self.target, faults=f"{AXES[0]} was 10 cm too large"),)


@claim
class RightPlace(Claim):
    """True if the target's place was within 3 cm along each axis of the one that was wanted; nothing on the grip."""

    kind = HP
    place: str
    """The target's place as text, relative to the hand where actions are."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return (
            _open(moment) and self.place == write(moment.action[:3]) and not _faults(moment.action, moment.before, lab)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        action = moment.action
        return (Off(action=action, target=write(action), faults=f"{AXES[2]} was 10 cm too small"),)


@claim
class RightGrip(Claim):
    """True if the grip was within 0.3 of the one that was wanted; nothing on the place."""

    kind = HP
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _open(moment) and self.grip == round(moment.action[3], 2) and not _slip(moment, lab)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Find fault."""
        action = moment.action
        return (SLIPS[1](action=action, target=write(action), grip=self.grip),)


@claim
class Neared(Claim):
    """True if the action took the hand from `before` to `after` centimetres from where it was wanted, and that is at
    least 1 cm nearer.
    """  # noqa: D205

    kind = HP
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again and measure."""
        return _moved(self, moment, lab) and self.before - self.after >= NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Turn it round."""
        return (Strayed(before=self.after, after=self.before),)


@claim
class Strayed(Claim):
    """True if the action took the hand from `before` to `after` centimetres from where it was wanted, and that is at
    least 1 cm farther away.
    """  # noqa: D205

    kind = HN
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action again and measure."""
        return _moved(self, moment, lab) and self.after - self.before >= NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Turn it round."""
        return (Neared(before=self.after, after=self.before),)


@claim
class Off(Claim):
    """True if the target's place was off by more than 3 cm along the named axes, by so many centimetres, and along no
    others.
    """  # noqa: D205

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    faults: str
    """Per axis how much too large or too small."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.faults == _faults(self.action, moment.before, lab) != ""

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (WellAimed(action=self.action, target=self.target), RightPlace(place=write(self.action[:3])))


@claim
class TooLoose(Claim):
    """True if the gripper should have been closed more: the grip was too small by more than 0.3."""

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.grip == round(self.action[3], 2) and _slip(moment, lab) < 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (RightGrip(grip=self.grip),)


@claim
class TooTight(Claim):
    """True if the gripper should have been opened more: the grip was too large by more than 0.3."""

    kind = HN
    action: Pose
    target: str
    """The action as text."""
    grip: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Ask metaworld's policy for its command."""
        return _judged(self, moment) and self.grip == round(self.action[3], 2) and _slip(moment, lab) > 0

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Praise it."""
        return (RightGrip(grip=self.grip),)


@claim
class Aiming(Claim):
    """True if `action` is, to two decimals, the pose that metaworld's scripted policy aims at in this state."""

    kind = FP
    action: Pose
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the pose from the policy's command and gain; a target that is out of reach is brought into it."""
        truth = moment.after
        place, grip = commanded(truth, lab)
        at = lab.target(truth, self.action)
        wanted = [min(max(w, a), b) for w, a, b in zip(place, *reach_of(truth, lab), strict=True)]
        return (
            not truth.solved
            and self.target == write(self.action)
            and all(abs(a - w) <= _ROUNDING for a, w in zip(at, wanted, strict=True))
            and abs(self.action[3] - grip) <= _ROUNDING
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the hand the other way, or elsewhere, with the other grip."""
        truth, (x, y, z, grip) = moment.after, self.action
        hand = (0.0, 0.0, 0.0) if lab.relative else hand_of(truth)
        mirrored = rounded((2 * hand[0] - x, 2 * hand[1] - y, 2 * hand[2] - z, -grip))
        elsewhere = rounded((x + 0.2, y, z, grip))
        return tuple(Aiming(action=action, target=write(action)) for action in (mirrored, elsewhere))

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """How far it is, and then in which direction."""
        hand, at = hand_of(moment.after), lab.target(moment.after, self.action)
        far = Distance(centimetres=round(100 * math.dist(hand, at)))
        ways = directions(hand, at)
        return (far, Heading(ways=ways)) if ways else (far,)


@claim
class Distance(Claim):
    """True if the place where the hand is wanted now is so far from it, to a centimetre or so."""

    kind = FP
    centimetres: int

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the place from the policy's command and gain."""
        truth = moment.after
        place, _ = commanded(truth, lab)
        return not truth.solved and abs(100 * math.dist(hand_of(truth), place) - self.centimetres) <= 2

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim another distance."""
        return (Distance(centimetres=self.centimetres + 15),)


@claim
class Heading(Claim):
    """True if the hand is wanted in this direction: along each named axis by more than 2 cm, give or take 1 cm."""

    kind = FP
    ways: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Compute the place from the policy's command and gain."""
        truth = moment.after
        place, _ = commanded(truth, lab)
        named = set(self.ways.split(" and "))
        sure, possible = (set(directions(hand_of(truth), place, slack).split(" and ")) for slack in (0.01, -0.01))
        return not truth.solved and named <= possible and sure - {""} <= named

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite direction."""
        return (Heading(ways=self.ways.translate(_OPPOSITE)),)


@claim
class Avoid(Claim):
    """True if `action` would take the hand from `before` to `after` centimetres from where it is wanted now, and that
    is at least 1 cm farther away.
    """  # noqa: D205

    kind = FN
    action: Pose
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Take the action in a copy of the simulator."""
        truth = moment.after
        return not truth.solved and _tried(self, truth, lab) and self.after - self.before >= NOTABLE

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the pose that is wanted, as if it led away."""
        action = action_for(lab.script.aim(moment.after.observation), moment.after, lab)
        return (Avoid(action=action, target=write(action), before=self.before, after=self.after),)


_ROUNDING = 0.005 + 1e-5  # of advice; commands are float32
_OPPOSITE = str.maketrans({"+": "-", "-": "+"})
SLIPS = (TooLoose, TooTight)
"""What is said of a grip that is too small, and of one that is too large."""


def _faults(action: Pose, truth: Truth, lab: World) -> str:
    return off_by(lab.target(truth, action), commanded(truth, lab)[0])


def _slip(moment: Moment, lab: World) -> int:
    """-1 if the grip of the action was too small, 1 if it was too large, else 0."""
    return slip_of(moment.action[3] - commanded(moment.before, lab)[1])


def _open(moment: Moment) -> bool:
    return moment.before is not None and not moment.before.solved


def _judged(said: WellAimed | Off | TooLoose | TooTight | Done, moment: Moment) -> bool:
    return _open(moment) and moment.action == said.action and said.target == write(said.action)


def _tried(said: TriedWell | TriedInVain | Avoid, truth: Truth, lab: World) -> bool:
    """Whether its action goes as it says."""
    place, _ = commanded(truth, lab)
    lab.restore(truth)
    lab.advance(said.action)
    ends = apart(hand_of(truth), place), apart(hand_of(lab.truth), place)
    return said.target == write(said.action) and _close((said.before, said.after), ends)


def _moved(said: Neared | Strayed, moment: Moment, lab: World) -> bool:
    if not _open(moment):
        return False
    place, _ = commanded(moment.before, lab)
    lab.restore(moment.before)
    lab.advance(moment.action)
    ends = apart(hand_of(moment.before), place), apart(hand_of(lab.truth), place)
    return _close((said.before, said.after), ends)


def _close(said: tuple[float, float], measured: tuple[float, float]) -> bool:
    """Equal, but for a last digit that the rounding of a command may have changed."""
    return all(abs(a - b) < 0.15 for a, b in zip(said, measured, strict=True))
