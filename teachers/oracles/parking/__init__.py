"""The oracle of the car park: it plans paths into the spot in a model and confirms claims in the simulator."""

import math
from collections.abc import Iterator, Set
from functools import lru_cache
from itertools import product

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, fast_constructor
from teachers.common import Syntax
from teachers.oracle import Oracle
from teachers.oracles.parking.checks import after_action, crashes, distance_to_spot, opposites, stops
from teachers.oracles.parking.claims import (
    Controls,
    Crash,
    Crashed,
    Detour,
    Doomed,
    Drive,
    Farther,
    Goal,
    Hazards,
    LineUp,
    Manoeuvre,
    Nearer,
    OnCourse,
    Parked,
    Strayed,
    Trap,
    TriedInVain,
    TriedWell,
    TurnBy,
    Within,
)
from teachers.oracles.parking.driving import solve
from teachers.oracles.parking.field import MARGIN, gain_of
from teachers.oracles.parking.model import BRAKES, TOLERANCE, Ground, brake, can_stop, misfit, misses, move
from worlds.parking import WALL_X, WALL_Y, Action, Car, Parking, Spot, Truth


@lru_cache(maxsize=16)
def _ground(spot: Spot, parked: tuple[Car, ...]) -> Ground:
    middles = tuple([(other.x, other.y) for other in parked])
    return Ground((spot.x, spot.y, spot.heading), TOLERANCE, middles, WALL_X, WALL_Y)


@lru_cache(maxsize=4096)
def _solved(spot: Spot, parked: tuple[Car, ...], car: tuple[float, float, float, float]) -> tuple[Action, ...]:
    return solve(_ground(spot, parked), car)


_TRIES = 2
_LOST = 100.0  # regret of a crash, in turns
_WASTE = 2  # least number of turns by which a plan must grow for negative hindsight
_ROUND = 10  # what is said of the number of actions is a multiple of this
_BEFORE = 12.0  # m; so far before the spot a car can line up with it
_NEWS = 0.05  # least change of distance, in m, for a claim
_EXTREMES = tuple(product((1.0, -1.0), (0.0, 1.0, -1.0)))
_CONTROLS = Controls(seconds=0.2, acceleration=5.0, degrees=45.0)
_HAZARDS = Hazards(wall_x=WALL_X, wall_y=WALL_Y)
# Elsewhere the fields of a claim are checked, which takes long for ways of many actions.
_on_course, _strayed = fast_constructor(OnCourse), fast_constructor(Strayed)
_nearer, _farther = fast_constructor(Nearer), fast_constructor(Farther)
_drive, _detour = fast_constructor(Drive), fast_constructor(Detour)


class ParkingOracle(Oracle[Truth, Parking]):
    """Plans a path into the spot from any state, keeps it while the student follows it, and judges actions by it.

    Claims about a path are checked by driving it. No claim says that a path is the shortest, as this is unknown: an
    action is good or bad by the lengths of the paths found before and after it, if `field`, which knows no paths,
    agrees with a margin.
    """

    max_importance = _LOST
    least_gain = _WASTE

    def start(self, truth: Truth) -> None:
        """Forget the paths of the last episode."""
        self._ways: dict[tuple[float, ...], tuple[Action, ...]] = {}
        self._seen: dict[Car, tuple[Action, ...]] = {}
        self._on: tuple[Truth, Ground] | None = None

    def _way(self, truth: Truth) -> tuple[Action, ...]:
        """Actions that park the car; empty if none were found or it is parked."""
        car = truth.car
        seen = self._seen.get(car)
        if seen is not None:
            return seen
        if car.crashed or car.impact is not None or self._is_parked(truth):
            return ()
        key = tuple([round(each, 6) for each in car[:4]])  # the model may differ from the simulator in the last digit
        way = self._ways.get(key)
        ground = self._ground(truth)
        if way is None:
            way = self._ways[key] = _solved(truth.spot, truth.parked, car[:4])
        if way:
            pedal, wheel = way[0]
            there = move(ground, car[:4], round(100 * pedal), round(100 * wheel))
            if there is not None and len(way) > 1:
                self._ways.setdefault(tuple([round(each, 6) for each in there]), way[1:])
        self._seen[car] = way
        return way

    def _ground(self, truth: Truth) -> Ground:
        last = self._on
        if last is None or last[0].parked != truth.parked or last[0].spot != truth.spot:
            last = self._on = truth, _ground(truth.spot, truth.parked)
        return last[1]

    def _stops(self, truth: Truth) -> bool:
        """As `checks.stops`; only close cases need the simulator."""
        car, ground = truth.car, self._ground(truth)
        if car.crashed or car.impact is not None:
            return False
        if can_stop(ground, car[:4]):
            return True
        bold = ground._replace(caution=-1)
        return stops(self.lab, truth, [wheel for wheel in BRAKES if brake(bold, car[:4], round(100 * wheel))[0]])

    def _is_parked(self, truth: Truth) -> bool:
        car = truth.car
        return misfit(self._ground(truth), car.x, car.y, car.heading) < TOLERANCE and not car.crashed

    def _turns(self, truth: Truth) -> float:
        """Number of turns of the path; `_LOST` if there is none."""
        if way := self._way(truth):
            return min(len(way), _LOST - 1)
        return 0.0 if self._is_parked(truth) else _LOST

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        x, y, heading = truth.spot
        goal = Goal(x=x, y=y, degrees=math.degrees(heading), tolerance=TOLERANCE)
        return goal, _HAZARDS, _CONTROLS, Syntax(expected=Parking.action_syntax)

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """The first action of the path, and random ones instead of it."""
        way = self._way(truth)
        if not way:
            return ()
        rest = way[1:]
        tried: list[Claim] = [TriedWell(action=way[0], rest=rest)]
        for _ in range(_TRIES):
            action = tuple(np.round(rng.uniform(-1, 1, 2), 2).tolist())
            if misses(self._ground(truth), truth.car[:4], (action, *rest)):
                tried.append(TriedInVain(action=action, rest=rest))
        return tuple(dict.fromkeys(tried))

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        way = self._way(truth)
        return (Manoeuvre(actions=way),) if way else ()

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        before, after, action = moment.past, moment.after, moment.action
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
        was, now = distance_to_spot(before), distance_to_spot(after)
        if wasted <= 0 and HP in kinds and (rest := self._way(after)):
            if gain_of(before, after) > MARGIN:
                claims.append(_on_course(action, (action, *rest)))
            if now - was < -_NEWS:
                claims.append(_nearer(action, was, now))
        elif wasted >= _WASTE and HN in kinds:
            if not self._way(after) and self._stops(before) and not self._stops(after):
                claims.append(Doomed(action=action))
            elif way and gain_of(before, after) < -MARGIN and misses(self._ground(after), after.car[:4], way[1:]):
                claims.append(_strayed(action, way))
            if now - was > _NEWS:
                claims.append(_farther(action, was, now))

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        if truth.car.crashed or not (kinds & {FP, FN}) or self._is_parked(truth):
            return
        if moment.before is not None:
            self._way(moment.before)  # so that the path does not depend on the kinds
        way = self._way(truth)
        if way and FP in kinds:
            claims.append(_drive(way[0], way[1:]))
        if FN in kinds:
            warning = next(self._warnings(truth, way, moment.turn), None)
            if warning:
                claims.append(warning)

    def _warnings(self, truth: Truth, way: tuple[Action, ...], turn: int) -> Iterator[Claim]:
        """Warnings, the most severe first."""
        yield from self._dangers(truth)
        if way:
            ground, others = self._ground(truth), opposites(way[0])
            for i in range(2):
                action = others[(turn + i) % 2]
                after = move(ground, truth.car[:4], *(round(100 * share) for share in action))
                if after is None or misfit(ground, *after[:3]) < TOLERANCE + _NEWS:
                    continue  # it may park the car itself
                detour = _solved(truth.spot, truth.parked, after)
                if len(detour) >= len(way):
                    yield _detour(action, way, detour)

    def _dangers(self, truth: Truth) -> Iterator[Claim]:
        """Actions that crash, or after which no braking prevents it; only close cases need the simulator."""
        car, ground = truth.car, self._ground(truth)
        near = 4.0 + 0.3 * abs(car.speed) + car.speed**2 / 8
        by_wall = abs(car.x) + near > WALL_X or abs(car.y) + near > WALL_Y
        if not by_wall and all(math.dist((other.x, other.y), (car.x, car.y)) > near + 3 for other in truth.parked):
            return
        bold = ground._replace(caution=-1)
        for action in _EXTREMES:
            pedal, wheel = (round(100 * share) for share in action)
            there = move(ground, car[:4], pedal, wheel)
            if there is None:
                if move(bold, car[:4], pedal, wheel) is None or crashes(self.lab, truth, action):
                    yield Crash(action=action)
            elif can_stop(ground, there) or not self._stops(truth):
                continue
            elif not can_stop(bold, there) or not self._stops(after_action(self.lab, truth, action)):
                yield Trap(action=action)

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """How far to turn, how many actions it takes, and from where it is straight ahead."""
        if truth.car.crashed or self._is_parked(truth):
            return ()
        x, y, heading = truth.spot
        clues: list[Claim] = []
        turn = math.remainder(heading - truth.car.heading, math.tau)
        if degrees := 30 * round(math.degrees(abs(turn)) / 30):
            clues.append(TurnBy(side="right" if turn > 0 else "left", degrees=degrees))
        if way := self._way(truth):
            ground = Drive(action=way[0], rest=way[1:])
            clues.append(Within.on(ground, count=-(-len(way) // _ROUND) * _ROUND))
        before = x - _BEFORE * math.cos(heading), y - _BEFORE * math.sin(heading)
        return (*clues, LineUp(x=round(before[0], 2), y=round(before[1], 2), degrees=round(math.degrees(heading), 1)))

    def importance(self, truth: Truth) -> float:
        """In turns: the regret of a crash if some action leads to one, else 1; 0 if the car is parked or crashed."""
        if truth.car.crashed or self._is_parked(truth):
            return 0.0
        return _LOST if any(self._dangers(truth)) else 1.0

    def plan(self, truth: Truth, n: int) -> tuple[Action, ...]:
        """The first `n` actions of the path."""
        return self._way(truth)[:n]

    def idle(self, truth: Truth) -> float:
        """1 turn, since the car does not move; 0 if it is parked or crashed."""
        return float(not truth.car.crashed and not self._is_parked(truth))

    def regret(self, moment: Moment[Truth]) -> float:
        """Number of turns by which the path has grown, including this turn; 100 for a crash."""
        before = moment.before
        if before is None:
            return self.idle(moment.after)
        if before.car.crashed or self._is_parked(before):
            return 0.0
        turns = self._turns(before)  # first, so that the path is found again after an action that follows it
        return max(0.0, self._turns(moment.after) + 1 - turns)
