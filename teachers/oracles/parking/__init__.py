"""The oracle of the car park: it plans ways into the spot, drives them in a model, and shows them in the simulator."""

import math
from collections.abc import Iterator, Sequence, Set
from functools import lru_cache
from itertools import product
from weakref import WeakKeyDictionary

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, claim
from teachers.common import Syntax
from teachers.driving import BRAKES, Ground, can_stop, misfit, misses, move, solve
from teachers.oracle import Oracle
from worlds.parking import LENGTH, WALL_X, WALL_Y, Action, Truth
from worlds.world import World

TOLERANCE = 1.44
"""highway-env's threshold for the reward, squared and counted in metres."""


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
                if _crash(lab, truth._replace(car=across)) != crash or _crash(lab, truth._replace(car=down)) != crash:
                    return False
        return all(_crash(lab, truth._replace(car=truth.car._replace(x=c.x, y=c.y))) for c in truth.parked)


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
            after = _after(lab, truth._replace(car=middle), (share, 0.0))
            if not math.isclose(after.car.speed, share * self.acceleration * self.seconds, rel_tol=1e-6):
                return False
            if not math.isclose(after.time - truth.time, self.seconds, rel_tol=1e-6):
                return False
            rolled = _after(lab, truth._replace(car=middle._replace(speed=1.0)), (0.0, share)).car.heading
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
        return _named(self) and _parks(lab, moment.after, (self.action, *self.rest)) and _counted(self)

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
        return _named(self) and _fails(lab, moment.after, (self.action, *self.rest)) and _counted(self)

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
            _parks(lab, moment.after, self.actions)
            and self.listing == listing
            and self.effort == _effort(len(self.actions))
        )


@claim
class Parked(Claim):
    """True if this action parked the car, without a crash."""

    kind = HP
    action: Action

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it again."""
        return _made(self, moment) and _parks(lab, moment.before, (self.action,))

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
            and _parks(lab, moment.before, (self.action, *self.rest))
            and self.effort == _effort(len(self.rest))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that the same way was left."""
        whole = (self.action, *self.rest)
        return (Strayed(action=self.action, instead=_write(self.action), effort=_effort(len(whole)), way=whole),)


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
        return _made(self, moment) and not moment.before.car.crashed and _crashes(lab, moment.before, self.action)

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
            and _stops(lab, moment.before)
            and not _crashes(lab, moment.before, self.action)
            and not _stops(lab, _after(lab, moment.before, self.action))
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
            and self.instead == _write(self.way[0])
            and self.effort == _effort(len(self.way))
            and _parks(lab, moment.before, self.way)
            and _fails(lab, moment.before, (self.action, *self.way[1:]))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Claim that the way was not left."""
        rest = self.way[1:]
        return (OnCourse(action=self.action, effort=_effort(len(rest)), rest=rest),)


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
            and self.doing == f"{_pedal(self.action)} and {_wheel(self.action)}"
            and _counted(self)
            and _parks(lab, moment.after, (self.action, *self.rest))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Promise the same of another action."""
        return (_drive((_opposites(self.action)[0], *self.rest)),)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Only the pedal, then pedal and wheel."""
        way = (self.action, *self.rest)
        pedal, wheel = _pedal(self.action), _wheel(self.action)
        return Push(pedal=pedal, way=way), Steer(pedal=pedal, wheel=wheel, way=way)


@claim
class Push(Claim):
    """True if the actions of `way` park the car and the first of them uses the pedal so."""

    kind = FP
    pedal: str
    way: tuple[Action, ...]

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive them."""
        return self.pedal == _pedal(self.way[0]) and _parks(lab, moment.after, self.way)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another pedal."""
        return tuple(Push(pedal=pedal, way=self.way) for pedal in _PEDALS if pedal != self.pedal)


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
        return self.pedal == _pedal(first) and self.wheel == _wheel(first) and _parks(lab, moment.after, self.way)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Another wheel."""
        return tuple(Steer(pedal=self.pedal, wheel=wheel, way=self.way) for wheel in _WHEELS if wheel != self.wheel)


@claim
class Crash(Claim):
    """True if the car crashes in `action`."""

    kind = FN
    action: Action
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Drive it."""
        return _named(self) and _crashes(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of other actions."""
        return tuple(Crash(action=other, target=_write(other)) for other in _opposites(self.action))


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
            and not _crashes(lab, moment.after, self.action)
            and _stops(lab, moment.after)
            and not _stops(lab, _after(lab, moment.after, self.action))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of other actions."""
        return tuple(Trap(action=other, target=_write(other)) for other in _opposites(self.action))


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
            and (self.effort, self.longer) == (_effort(len(self.way)), _effort(len(whole)))
            and len(whole) > len(self.way)
            and _parks(lab, truth, self.way)
            and _parks(lab, truth, whole)
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Exaggerate."""
        return (Crash(action=self.action, target=self.target),)


def _after(lab: World, truth: Truth, action: Action) -> Truth:
    lab.restore(truth)
    lab.advance(action)
    return lab.truth


def _crash(lab: World, truth: Truth) -> bool:
    """Whether a car that waits crashes, and the episode ends by it."""
    lab.restore(truth)
    _, _, terminated, _, info = lab.advance((0.0, 0.0))
    return terminated and info["crashed"]


def _crashes(lab: World, truth: Truth, action: Action) -> bool:
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


def _parks(lab: World, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the last of the actions parks the car, and none before."""
    return bool(actions) and _outcome(lab, truth, actions) == len(actions)


def _fails(lab: World, truth: Truth, actions: tuple[Action, ...]) -> bool:
    """Whether the car is not parked by any of the actions."""
    return not _outcome(lab, truth, actions)


def _stops(lab: World, truth: Truth) -> bool:
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


def _made(said: Claim, moment: Moment) -> bool:
    return moment.before is not None and moment.action == said.action  # type: ignore[attr-defined]


def _covered(said: Nearer | Farther, moment: Moment, lab: World) -> bool:
    if not _made(said, moment):
        return False
    after = _after(lab, moment.before, said.action)
    return (said.before, said.after) == (_distance(moment.before), _distance(after))


def _distance(truth: Truth) -> float:
    """From the middle of the car to that of the spot, in metres."""
    return math.hypot(truth.car.x - truth.spot.x, truth.car.y - truth.spot.y)


def _named(said: TriedWell | TriedInVain | Drive | Crash | Trap | Detour) -> bool:
    """Whether the text of a claim's action is that action."""
    return said.target == _write(said.action)


def _counted(said: TriedWell | TriedInVain | Drive) -> bool:
    return said.effort == _effort(1 + len(said.rest))


def _write(action: Action) -> str:
    return f"[{action[0]!r}, {action[1]!r}]"


def _effort(count: int) -> str:
    return "1 action" if count == 1 else f"{count} actions"


_PEDALS = ("push backwards", "leave the pedals alone", "push forwards")
_WHEELS = ("turn the wheel to the left", "hold the wheel straight", "turn the wheel to the right")


def _pedal(action: Action) -> str:
    return _PEDALS[1 + (action[0] > 0) - (action[0] < 0)]


def _wheel(action: Action) -> str:
    return _WHEELS[1 + (action[1] > 0) - (action[1] < 0)]


def _drive(way: tuple[Action, ...]) -> Drive:
    first, *rest = way
    doing = f"{_pedal(first)} and {_wheel(first)}"
    return Drive(action=first, target=_write(first), doing=doing, effort=_effort(len(way)), rest=tuple(rest))


def _opposites(action: Action) -> tuple[Action, ...]:
    """Plausible actions that differ much from this one."""
    pedal, wheel = (-1.0 if share > 0 else 1.0 for share in action)
    return (pedal, wheel), (pedal, action[1]), (0.0, 0.0)


@lru_cache(maxsize=16)
def _ground(spot: tuple[float, float, float], places: tuple[tuple[float, float], ...]) -> Ground:
    return Ground(tuple(spot), TOLERANCE, places, WALL_X, WALL_Y)


_TRIES = 2
_LOST = 100.0  # turns that a crash costs
_WASTE = 2  # turns that a plan must have grown by for blame
_NEWS = 0.05  # m that are worth mentioning
_EXTREMES = tuple(product((1.0, -1.0), (0.0, 1.0, -1.0)))
_CONTROLS = Controls(seconds=0.2, acceleration=5.0, degrees=45.0)
_HAZARDS = Hazards(wall_x=WALL_X, wall_y=WALL_Y)


class ParkingOracle(Oracle):
    """Plans a way into the spot from any state, keeps to it while the student does, and judges by it.

    What is said of a way is shown by driving it. That a way is the shortest is not known and never said; whether to
    blame or to praise an action is decided by the lengths of the ways found before and after it, with a margin.
    """

    max_importance = _LOST

    def start(self, truth: Truth, rng: np.random.Generator) -> None:
        """Know no way yet."""
        super().start(truth, rng)
        self._ways: dict[tuple[float, ...], tuple[Action, ...]] = {}

    def _way(self, truth: Truth) -> tuple[Action, ...]:
        """Actions that park the car, as few as were found; none if none were, or if it is parked."""
        car = truth.car
        if car.crashed or car.impact is not None or self._is_parked(truth):
            return ()
        key = tuple([round(each, 6) for each in car[:4]])  # what the model foresaw may differ in the last digit
        way = self._ways.get(key)
        ground = self._ground(truth)
        if way is None:
            way = self._ways[key] = solve(ground, car[:4])
        if way:
            pedal, wheel = way[0]
            there = move(ground, car[:4], round(100 * pedal), round(100 * wheel))
            if there is not None and len(way) > 1:
                self._ways.setdefault(tuple([round(each, 6) for each in there]), way[1:])
        return way

    def _ground(self, truth: Truth) -> Ground:
        return _ground(truth.spot, tuple([(other.x, other.y) for other in truth.parked]))

    def _is_parked(self, truth: Truth) -> bool:
        car = truth.car
        return misfit(self._ground(truth), car.x, car.y, car.heading) < TOLERANCE and not car.crashed

    def _turns(self, truth: Truth) -> float:
        """Turns that the way takes; `_LOST` if there is none."""
        if way := self._way(truth):
            return min(len(way), _LOST - 1)
        return 0.0 if self._is_parked(truth) else _LOST

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        x, y, heading = truth.spot
        goal = Goal(x=x, y=y, degrees=math.degrees(heading), tolerance=TOLERANCE)
        return goal, _HAZARDS, _CONTROLS, Syntax(expected=self.lab.action_syntax)

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """The way's first action, and random ones in its place."""
        way = self._way(truth)
        if not way:
            return ()
        effort, rest = _effort(len(way)), way[1:]
        told: list[Claim] = [TriedWell(action=way[0], target=_write(way[0]), effort=effort, rest=rest)]
        for _ in range(_TRIES):
            action = tuple(np.round(self.rng.uniform(-1, 1, 2), 2).tolist())
            if misses(self._ground(truth), truth.car[:4], (action, *rest)):
                told.append(TriedInVain(action=action, target=_write(action), effort=effort, rest=rest))
        return tuple(dict.fromkeys(told))

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        way = self._way(truth)
        if not way:
            return ()
        listing = ", ".join(f"[{pedal!r},{wheel!r}]" for pedal, wheel in way)
        return (Manoeuvre(actions=way, listing=listing, effort=_effort(len(way))),)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        before, after, action = moment.before, moment.after, moment.action
        if before.car.crashed or not (kinds & {HP, HN}) or self._is_parked(before):
            return
        if after.car.crashed:
            if HN in kinds:
                claims.append(Crashed(action=action))
            return
        if moment.success:
            if HP in kinds:
                claims.append(Parked(action=action))
            return
        way, turns = self._way(before), self._turns(before)
        wasted = self._turns(after) + 1 - turns
        moved = _distance(after) - _distance(before)
        far = {"action": action, "before": _distance(before), "after": _distance(after)}
        if wasted <= 0 and HP in kinds and (rest := self._way(after)):
            claims.append(OnCourse(action=action, effort=_effort(len(rest)), rest=rest))
            if moved < -_NEWS:
                claims.append(Nearer(**far))
        elif wasted >= _WASTE and HN in kinds:
            if not self._way(after) and _stops(self.lab, before) and not _stops(self.lab, after):
                claims.append(Doomed(action=action))
            elif way and misses(self._ground(after), after.car[:4], way[1:]):
                claims.append(Strayed(action=action, instead=_write(way[0]), effort=_effort(len(way)), way=way))
            if moved > _NEWS:
                claims.append(Farther(**far))

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        if truth.car.crashed or not (kinds & {FP, FN}) or self._is_parked(truth):
            return
        if moment.before is not None:
            self._way(moment.before)  # so that a way is kept to whichever kinds are wanted
        way = self._way(truth)
        if way and FP in kinds:
            claims.append(_drive(way))
        if FN in kinds:
            warning = next(self._warnings(truth, way, moment.turn), None)
            if warning:
                claims.append(warning)

    def _warnings(self, truth: Truth, way: tuple[Action, ...], turn: int) -> Iterator[Claim]:
        """What not to do, the worst first."""
        yield from self._dangers(truth)
        if way:
            ground, others = self._ground(truth), _opposites(way[0])
            for i in range(2):
                action = others[(turn + i) % 2]
                after = move(ground, truth.car[:4], *(round(100 * share) for share in action))
                if after is None or misfit(ground, *after[:3]) < TOLERANCE + _NEWS:
                    continue  # it may park the car itself
                detour = solve(ground, after)
                if len(detour) >= len(way):
                    yield Detour(
                        action=action,
                        target=_write(action),
                        effort=_effort(len(way)),
                        longer=_effort(1 + len(detour)),
                        way=way,
                        detour=detour,
                    )

    def _dangers(self, truth: Truth) -> Iterator[Claim]:
        """Actions that crash, or after which no braking helps."""
        car, ground = truth.car, self._ground(truth)
        near = 4.0 + 0.3 * abs(car.speed) + car.speed**2 / 8
        by_wall = abs(car.x) + near > WALL_X or abs(car.y) + near > WALL_Y
        if not by_wall and all(math.dist((other.x, other.y), (car.x, car.y)) > near + 3 for other in truth.parked):
            return
        for action in _EXTREMES:
            there = move(ground, car[:4], *(round(100 * share) for share in action))
            if there is None and _crashes(self.lab, truth, action):
                yield Crash(action=action, target=_write(action))
            elif there is not None and not can_stop(ground, there):
                trap = Trap(action=action, target=_write(action))
                if _stops(self.lab, truth) and not _stops(self.lab, _after(self.lab, truth, action)):
                    yield trap

    def importance(self, truth: Truth) -> float:
        """1 turn, all that is lost by a crash where some action leads to one, or 0 when it is over."""
        if truth.car.crashed or self._is_parked(truth):
            return 0.0
        return _LOST if any(self._dangers(truth)) else 1.0

    def plan(self, truth: Truth, n: int) -> tuple[Action, ...]:
        """The way, or its beginning."""
        return self._way(truth)[:n]

    def regret(self, moment: Moment) -> float:
        """Turns by which the way has grown, the turn included; a crash costs 100."""
        before = moment.before
        if before is None:
            return self.importance(moment.after)
        if before.car.crashed or self._is_parked(before):
            return 0.0
        turns = self._turns(before)  # first, so that a way that was followed is known after it
        return max(0.0, self._turns(moment.after) + 1 - turns)
