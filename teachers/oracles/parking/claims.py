"""Claims about parking, each checked in the simulator."""

import math
from collections.abc import Sequence
from typing import Annotated, Any

from teachers.atoms import (
    FN,
    FP,
    HN,
    HP,
    ActionClaim,
    Claim,
    Grounded,
    Moment,
    PlanClaim,
    Scope,
    Verdict,
    claim,
    opposed,
    slot,
)
from teachers.common import ChangeVerdict
from teachers.oracles.parking.checks import (
    PEDALS,
    SIDES,
    WHEELS,
    after_action,
    crashes,
    distance_to_spot,
    dooms,
    effort_of,
    fails,
    leads_in,
    obeys,
    opposites,
    parks,
    parks_within,
    pedal_words,
    stands_at,
    turn_to_spot,
    wheel_words,
    write,
)
from teachers.oracles.parking.field import MARGIN, gain_of
from teachers.spec import Range
from worlds.parking import Action, Parking, Truth

Share = Annotated[float, Range(-1, 1)]
"""A number of an action."""
Way = tuple[tuple[Share, Share], ...]
"""Actions in order."""


@claim
class Goal(Claim[Truth, Parking]):
    """True if the car is parked exactly when its misfit is below `tolerance`.

    The misfit is |x error| + 0.3 |y error| + 2 |error of the heading's cosine| + 2 |error of its sine|, in metres.
    """

    x: float
    y: float
    degrees: float
    """Heading of a car in the spot."""
    tolerance: float

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Put the car in many poses."""
        return parks_within(lab, moment.after, (self.x, self.y, math.radians(self.degrees)), self.tolerance)


@claim
class Hazards(Claim[Truth, Parking]):
    """True if touching a wall, at plus and minus these coordinates in metres, or another car is a crash, and an end."""

    wall_x: float
    wall_y: float

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Put the car in front of each wall, into it, and into the other cars."""
        return stands_at(lab, moment.after, self.wall_x, self.wall_y)


@claim
class Controls(Claim[Truth, Parking]):
    """True if an action lasts `seconds`, its first number is an acceleration and its second one turns the wheels.

    1 stands for `acceleration`, in m/s2, forwards, and for `degrees` to the driver's right, where headings grow.
    """

    seconds: float
    acceleration: float
    degrees: float

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Push from rest, and roll with the wheels turned."""
        return obeys(lab, moment.after, self.seconds, self.acceleration, math.radians(self.degrees))


@claim
class _Named(ActionClaim[Truth, Parking]):
    action_slot = "target"
    action: Action
    target = slot(write, "action")


@claim
class _Begun(_Named):
    rest: Way

    @property
    def whole(self) -> tuple[Action, ...]:
        """The action, then `rest`."""
        return (self.action, *self.rest)

    @property
    def effort(self) -> str:
        """The number of all these actions, in words."""
        return effort_of(1 + len(self.rest))


@claim
class _Tried(Verdict[Truth, Parking], _Begun):
    tried = True

    def applies(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them all: none parks the car before the last."""
        return self.good(moment, lab) or fails(lab, moment.after, self.whole)

    def good(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them all: the last parks the car."""
        return parks(lab, moment.after, self.whole)


@claim
class TriedWell(_Tried):
    """True if `action`, and then those of `rest`, park the car from the start."""

    kind = HP


@claim
class TriedInVain(_Tried):
    """True if the actions of `rest`, which park the car after another first action, do not do so after `action`."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Manoeuvre(PlanClaim[Truth, Parking]):
    """True if these actions, in order, park the car."""

    actions: tuple[Action, ...]

    @property
    def listing(self) -> str:
        """The actions as text."""
        return self.separator.join(f"[{pedal!r},{wheel!r}]" for pedal, wheel in self.actions)

    @property
    def effort(self) -> str:
        """The number of actions, in words."""
        return effort_of(len(self.actions))

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them."""
        return parks(lab, moment.after, self.actions)


@claim
class _Made(ActionClaim[Truth, Parking]):
    action_slot = ""  # phrases call it "that": it is the student's own
    action: Action

    def made(self, moment: Moment[Truth]) -> bool:
        """Whether `action` is the action of this turn."""
        return moment.before is not None and bool(moment.action == self.action)


@claim
class Parked(_Made):
    """True if this action parked the car, without a crash."""

    kind = HP

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive it again."""
        return self.made(moment) and parks(lab, moment.past, (self.action,))

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """The claim of a crash."""
        return (Crashed(action=self.action),)


@claim
class Crashed(_Made):
    """True if the car crashed in this action."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive it again."""
        return self.made(moment) and not moment.past.car.crashed and crashes(lab, moment.past, self.action)

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """The claim of success."""
        return (Parked(action=self.action),)


@claim
class Doomed(_Made):
    """True if before this action full braking saved the car with some, and after it with none of the `BRAKES`."""

    kind = HN

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Brake before it and after it."""
        return self.made(moment) and dooms(lab, moment.past, self.action)

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """The claim of success."""
        return (Parked(action=self.action),)


@claim
class _Followed(Verdict[Truth, Parking], _Made):
    way: Way

    @property
    def effort(self) -> str:
        """The number of actions of the way, in words; without the first if the action began it."""
        return effort_of(len(self.way) - (self.kind is HP))

    def applies(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive the way from before the action, and its rest after it; both must agree with the field."""
        if not self.made(moment) or not parks(lab, moment.past, self.way):
            return False
        gain, rest = gain_of(moment.past, moment.after), (self.action, *self.way[1:])
        return parks(lab, moment.past, rest) if gain > MARGIN else gain < -MARGIN and fails(lab, moment.past, rest)

    def good(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Whether the action shortened the drive, by the field."""
        return gain_of(moment.past, moment.after) > MARGIN


@claim
class OnCourse(_Followed):
    """True if the action shortened the drive into the spot, as `field` measures it, by more than a quarter of a turn;
    and the actions of `way` parked the car from before this action, and all but the first do so after it.
    """  # noqa: D205

    kind = HP


@claim
class Strayed(_Followed):
    """True if the action lengthened the drive into the spot, as `field` measures it, by more than a quarter of a turn;
    and the actions of `way` parked the car from before this action, but all but the first do not after it.
    """  # noqa: D205

    kind = HN

    @property
    def instead(self) -> str:
        """The first action of the way, as text."""
        return write(self.way[0])


opposed(OnCourse, Strayed)


@claim
class _Moved(ChangeVerdict[Truth, Parking], _Made):
    before: float
    after: float

    def applies(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive it again and measure; equal distances are no verdict."""
        return (
            self.made(moment)
            and self.before == distance_to_spot(moment.past)
            and self.after == distance_to_spot(after_action(lab, moment.past, self.action)) != self.before
        )


@claim
class Nearer(_Moved):
    """True if this action took the car nearer to the middle of the spot: from `before` to `after`, in metres."""

    kind = HP


@claim
class Farther(_Moved):
    """True if this action took the car away from the middle of the spot: from `before` to `after`, in metres."""

    kind = HN


opposed(Nearer, Farther)


@claim
class Drive(_Begun):
    """True if `action`, and then those of `rest`, park the car; no earlier, and without a crash."""

    kind = FP

    @property
    def doing(self) -> str:
        """The action in words."""
        return f"{pedal_words(self.action)} and {wheel_words(self.action)}"

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them."""
        return parks(lab, moment.after, self.whole)

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """The same advice with another action."""
        return (Drive(action=opposites(self.action)[0], rest=self.rest),)

    def coarser(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """Only the pedal, then pedal and wheel."""
        pedal, wheel = pedal_words(self.action), wheel_words(self.action)
        return Push(pedal=pedal, way=self.whole), Steer(pedal=pedal, wheel=wheel, way=self.whole)


@claim
class Push(Claim[Truth, Parking]):
    """True if the actions of `way` park the car and the first of them uses the pedal so."""

    kind = FP
    pedal: Annotated[str, PEDALS]
    way: Way
    counterparts = Claim.varied("pedal", PEDALS)

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them."""
        return self.pedal == pedal_words(self.way[0]) and parks(lab, moment.after, self.way)


@claim
class Steer(Push):
    """True if the actions of `way` park the car and the first of them uses pedal and wheel so."""

    wheel: Annotated[str, WHEELS]
    counterparts = Claim.varied("wheel", WHEELS)

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them."""
        return self.wheel == wheel_words(self.way[0]) and Push.holds(self, moment, lab)


@claim
class _Warning(_Named):
    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """Warn of other actions."""
        return tuple(type(self)(action=other) for other in opposites(self.action))


@claim
class Crash(_Warning):
    """True if the car crashes in `action`."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive it."""
        return crashes(lab, moment.after, self.action)


@claim
class Trap(_Warning):
    """True if now full braking saves the car with some, and after `action` with none of the `BRAKES`."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Brake now, and after it."""
        return dooms(lab, moment.after, self.action)


@claim
class Detour(_Named):
    """True if the actions of `way` park the car from here, and more are needed for another way, begun by `action`.

    After `action` that way is the actions of `detour`.
    """

    kind = FN
    way: Way
    detour: Way

    @property
    def effort(self) -> str:
        """The number of actions of the way."""
        return effort_of(len(self.way))

    @property
    def longer(self) -> str:
        """The number of actions of the detour, with `action`."""
        return effort_of(1 + len(self.detour))

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive both."""
        truth, whole = moment.after, (self.action, *self.detour)
        return len(whole) > len(self.way) and parks(lab, truth, self.way) and parks(lab, truth, whole)

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """The claim of a crash."""
        return (Crash(action=self.action),)


@claim
class TurnBy(Claim[Truth, Parking]):
    """True if the car's heading is so far, to 15 degrees, from that of a car in the spot, to this side."""

    kind = FP
    side: Annotated[str, (*SIDES,)]
    degrees: Annotated[int, Range(0, 360)]
    counterparts = Claim.varied("side", SIDES)

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Read both headings off the observation."""
        turn = turn_to_spot(lab, moment.after)
        return abs(math.remainder(turn - SIDES[self.side] * self.degrees, 360)) <= _CLOSE

    def excludes(self, other: Claim) -> bool:
        """Another turn."""
        return isinstance(other, TurnBy) and other != self


@claim
class Within(Grounded[Truth, Parking]):
    """True if at most so many actions are enough to park the car: its ground is the advice that begins them."""

    kind = FP
    count: Annotated[int, Range(1, 999)]

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Drive them."""
        return len(self._ground.whole) <= self.count and self.stands(moment, lab)

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Look for a way."""
        return 0 < len(oracle.plan(moment.after, self.count + 1)) <= self.count


@claim
class LineUp(Claim[Truth, Parking]):
    """True if a car that stands here, with this heading, gets into the spot without turning the wheel."""

    kind = FP
    scope = Scope.WORLD
    x: float
    y: float
    degrees: float

    def holds(self, moment: Moment[Truth], lab: Parking) -> bool:
        """Put the student's car there, and drive straight ahead."""
        return leads_in(lab, moment.after, (self.x, self.y, math.radians(self.degrees)))

    def counterparts(self, moment: Moment[Truth], lab: Parking) -> Sequence[Claim]:
        """A place in front of another spot, or heading away."""
        return (
            LineUp(x=self.x + 12.0, y=self.y, degrees=self.degrees),
            LineUp(x=self.x, y=self.y, degrees=self.degrees + 180.0),
        )


_CLOSE = 15 + 1e-6  # degrees
