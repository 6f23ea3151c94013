"""What is said about parking a car, each with its trial in the simulator."""

import math
from collections.abc import Sequence
from itertools import product

from teachers.atoms import FN, FP, HN, HP, Claim, Moment, claim
from teachers.oracles.parking.checks import (
    PEDALS,
    WHEELS,
    after_action,
    crashes,
    distance_to_spot,
    effort_of,
    fails,
    hits,
    parks,
    pedal_words,
    stops,
    wheel_words,
    write,
)
from worlds.parking import LENGTH, Action
from worlds.world import World


@claim
class Goal(Claim):
    """True if the car is parked exactly when its misfit is below `tolerance`.

    The misfit is |x error| + 0.3 |y error| + 2 |error of the heading's cosine| + 2 |error of its sine|, in metres.
    """

    x: float
    y: float
    degrees: float
    """Heading of a car in the spot."""
    tolerance: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Put the car in many places and wait."""
        goal = math.radians(self.degrees)
        out = -math.copysign(1.0, self.y)  # away from the wall
        away = tuple(other._replace(x=1e3 + 9 * i) for i, other in enumerate(moment.after.parked))
        truth = moment.after._replace(parked=away)
        turns = (0.0, 0.1, -0.3, 0.5, math.pi)
        for dx, dy, turn in product((0.0, 0.4, -0.9, 1.3, 1.5), (0.0, 1.0, 2.5, 4.0, 4.9), turns):
            car = truth.car._replace(x=self.x + dx, y=self.y + out * dy, heading=goal + turn, speed=0.0)
            cosine, sine = math.cos(car.heading) - math.cos(goal), math.sin(car.heading) - math.sin(goal)
            off = abs(dx) + 0.3 * abs(dy) + 2 * abs(cosine) + 2 * abs(sine)
            lab.restore(truth._replace(car=car))
            if lab.advance((0.0, 0.0))[4]["is_success"] != (off < self.tolerance):
                return False
        return True


@claim
class Hazards(Claim):
    """True if touching a wall, at plus and minus these coordinates in metres, or another car is a crash, and an end."""

    wall_x: float
    wall_y: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Put the car in front of each wall, into it, and into the other cars."""
        truth = moment.after
        x, y = self.wall_x - LENGTH / 2, self.wall_y - LENGTH / 2
        for side, turn in product((1, -1), (0.0, math.pi)):
            for along, crash in ((-0.01, False), (0.01, True)):
                across = truth.car._replace(x=side * (x + along), y=0.0, heading=turn, speed=0.0)
                down = truth.car._replace(x=0.0, y=side * (y + along), heading=turn + math.pi / 2, speed=0.0)
                if hits(lab, truth._replace(car=across)) != crash or hits(lab, truth._replace(car=down)) != crash:
                    return False
        return all(hits(lab, truth._replace(car=truth.car._replace(x=c.x, y=c.y))) for c in truth.parked)


@claim
class Controls(Claim):
    """True if an action lasts `seconds`, its first number is an acceleration and its second one turns the wheels.

    1 stands for `acceleration`, in m/s2, forwards, and for `degrees` to the driver's right, where headings grow.
    """

    seconds: float
    acceleration: float
    degrees: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Push from rest, and roll with the wheels turned."""
        truth = moment.after
        middle = truth.car._replace(x=0.0, y=0.0, heading=0.0, speed=0.0)
        for share in (-1.0, -0.5, 0.5, 1.0):
            after = after_action(lab, truth._replace(car=middle), (share, 0.0))
            if not math.isclose(after.car.speed, share * self.acceleration * self.seconds, rel_tol=1e-6):
                return False
            if not math.isclose(after.time - truth.time, self.seconds, rel_tol=1e-6):
                return False
            rolled = after_action(lab, truth._replace(car=middle._replace(speed=1.0)), (0.0, share)).car.heading
            slip = math.atan(math.tan(math.radians(share * self.degrees)) / 2)
            if not math.isclose(rolled, self.seconds * math.sin(slip) / (LENGTH / 2), rel_tol=1e-5):
                return False
        return True


@claim
class TriedWell(Claim):
    """True if `action`, and then those of `rest`, park the car from the start."""

    kind = HP
    action: Action
    target: str
    """The action as text."""
    effort: str
    """How many actions that is in all."""
    rest: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        return _named(self) and parks(lab, moment.after, (self.action, *self.rest)) and _counted(self)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, target=self.target, effort=self.effort, rest=self.rest),)


@claim
class TriedInVain(Claim):
    """True if the actions of `rest`, which park the car after another first action, do not do so after `action`."""

    kind = HN
    action: Action
    target: str
    """The action as text."""
    effort: str
    """How many actions the other way is in all."""
    rest: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them after it."""
        return _named(self) and fails(lab, moment.after, (self.action, *self.rest)) and _counted(self)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, target=self.target, effort=self.effort, rest=self.rest),)


@claim
class Manoeuvre(Claim):
    """True if these actions, in order, park the car."""

    actions: tuple[Action, ...]
    listing: str
    effort: str

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        listing = ", ".join(f"[{pedal!r},{wheel!r}]" for pedal, wheel in self.actions)
        return (
            parks(lab, moment.after, self.actions)
            and self.listing == listing
            and self.effort == effort_of(len(self.actions))
        )


@claim
class Parked(Claim):
    """True if this action parked the car, without a crash."""

    kind = HP
    action: Action

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it again."""
        return _made(self, moment) and parks(lab, moment.before, (self.action,))

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Call it a crash."""
        return (Crashed(action=self.action),)


@claim
class OnCourse(Claim):
    """True if after this action those of `rest` park the car; `effort` is their number."""

    kind = HP
    action: Action
    effort: str
    rest: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them all, from before the action."""
        return (
            _made(self, moment)
            and parks(lab, moment.before, (self.action, *self.rest))
            and self.effort == effort_of(len(self.rest))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that the same way was left."""
        whole = (self.action, *self.rest)
        return (Strayed(action=self.action, instead=write(self.action), effort=effort_of(len(whole)), way=whole),)


@claim
class Nearer(Claim):
    """True if this action took the car nearer to the middle of the spot: from `before` to `after`, in metres."""

    kind = HP
    action: Action
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it again."""
        return _covered(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite."""
        return (Farther(action=self.action, before=self.after, after=self.before),)


@claim
class Crashed(Claim):
    """True if the car crashed in this action."""

    kind = HN
    action: Action

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it again."""
        return _made(self, moment) and not moment.before.car.crashed and crashes(lab, moment.before, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Call it a success."""
        return (Parked(action=self.action),)


@claim
class Doomed(Claim):
    """True if before this action full braking saved the car with some, and after it with none of the `BRAKES`."""

    kind = HN
    action: Action

    def holds(self, moment: Moment, lab: World) -> bool:
        """Brake before it and after it."""
        return (
            _made(self, moment)
            and stops(lab, moment.before)
            and not crashes(lab, moment.before, self.action)
            and not stops(lab, after_action(lab, moment.before, self.action))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Call it a success."""
        return (Parked(action=self.action),)


@claim
class Strayed(Claim):
    """True if the actions of `way` parked the car from before this action, but all but the first do not after it."""

    kind = HN
    action: Action
    instead: str
    """The first action of the way, as text."""
    effort: str
    """The number of actions of the way."""
    way: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive the way, and what is left of it after the action."""
        return (
            _made(self, moment)
            and self.instead == write(self.way[0])
            and self.effort == effort_of(len(self.way))
            and parks(lab, moment.before, self.way)
            and fails(lab, moment.before, (self.action, *self.way[1:]))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that the way was not left."""
        rest = self.way[1:]
        return (OnCourse(action=self.action, effort=effort_of(len(rest)), rest=rest),)


@claim
class Farther(Claim):
    """True if this action took the car away from the middle of the spot: from `before` to `after`, in metres."""

    kind = HN
    action: Action
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it again."""
        return _covered(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite."""
        return (Nearer(action=self.action, before=self.after, after=self.before),)


@claim
class Drive(Claim):
    """True if `action`, and then those of `rest`, park the car; no earlier, and without a crash."""

    kind = FP
    action: Action
    target: str
    """The action as text."""
    doing: str
    """The action in words."""
    effort: str
    """How many actions that is in all."""
    rest: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        return (
            _named(self)
            and self.doing == f"{pedal_words(self.action)} and {wheel_words(self.action)}"
            and _counted(self)
            and parks(lab, moment.after, (self.action, *self.rest))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Promise the same of another action."""
        return (drive((opposites(self.action)[0], *self.rest)),)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Only the pedal, then pedal and wheel."""
        way = (self.action, *self.rest)
        pedal, wheel = pedal_words(self.action), wheel_words(self.action)
        return Push(pedal=pedal, way=way), Steer(pedal=pedal, wheel=wheel, way=way)


@claim
class Push(Claim):
    """True if the actions of `way` park the car and the first of them uses the pedal so."""

    kind = FP
    pedal: str
    way: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        return self.pedal == pedal_words(self.way[0]) and parks(lab, moment.after, self.way)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another pedal."""
        return tuple(Push(pedal=pedal, way=self.way) for pedal in PEDALS if pedal != self.pedal)


@claim
class Steer(Claim):
    """True if the actions of `way` park the car and the first of them uses pedal and wheel so."""

    kind = FP
    pedal: str
    wheel: str
    way: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        first = self.way[0]
        return (
            self.pedal == pedal_words(first) and self.wheel == wheel_words(first) and parks(lab, moment.after, self.way)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another wheel."""
        return tuple(Steer(pedal=self.pedal, wheel=wheel, way=self.way) for wheel in WHEELS if wheel != self.wheel)


@claim
class Crash(Claim):
    """True if the car crashes in `action`."""

    kind = FN
    action: Action
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it."""
        return _named(self) and crashes(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of other actions."""
        return tuple(Crash(action=other, target=write(other)) for other in opposites(self.action))


@claim
class Trap(Claim):
    """True if now full braking saves the car with some, and after `action` with none of the `BRAKES`."""

    kind = FN
    action: Action
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Brake now, and after it."""
        return (
            _named(self)
            and not crashes(lab, moment.after, self.action)
            and stops(lab, moment.after)
            and not stops(lab, after_action(lab, moment.after, self.action))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of other actions."""
        return tuple(Trap(action=other, target=write(other)) for other in opposites(self.action))


@claim
class Detour(Claim):
    """True if the actions of `way` park the car from here, and more are needed for another way, begun by `action`.

    After `action` that way is the actions of `detour`.
    """

    kind = FN
    action: Action
    target: str
    """The action as text."""
    effort: str
    """The number of actions of the way."""
    longer: str
    """The number of actions of the detour, with `action`."""
    way: tuple[Action, ...]
    detour: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive both."""
        truth, whole = moment.after, (self.action, *self.detour)
        return (
            _named(self)
            and (self.effort, self.longer) == (effort_of(len(self.way)), effort_of(len(whole)))
            and len(whole) > len(self.way)
            and parks(lab, truth, self.way)
            and parks(lab, truth, whole)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Exaggerate."""
        return (Crash(action=self.action, target=self.target),)


def _made(said: Claim, moment: Moment) -> bool:
    return moment.before is not None and moment.action == said.action  # type: ignore[attr-defined]


def _covered(said: Nearer | Farther, moment: Moment, lab: World) -> bool:
    if not _made(said, moment):
        return False
    after = after_action(lab, moment.before, said.action)
    return (said.before, said.after) == (distance_to_spot(moment.before), distance_to_spot(after))


def _named(said: TriedWell | TriedInVain | Drive | Crash | Trap | Detour) -> bool:
    """Whether the text of a claim's action is that action."""
    return said.target == write(said.action)


def _counted(said: TriedWell | TriedInVain | Drive) -> bool:
    return said.effort == effort_of(1 + len(said.rest))


def drive(way: tuple[Action, ...]) -> Drive:
    """Advice to drive this way."""
    first, *rest = way
    doing = f"{pedal_words(first)} and {wheel_words(first)}"
    return Drive(action=first, target=write(first), doing=doing, effort=effort_of(len(way)), rest=tuple(rest))


def opposites(action: Action) -> tuple[Action, ...]:
    """Plausible actions that differ much from this one."""
    pedal, wheel = (-1.0 if share > 0 else 1.0 for share in action)
    return (pedal, wheel), (pedal, action[1]), (0.0, 0.0)
