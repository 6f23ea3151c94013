"""The claims about proposals, each checked by making the proposals in the lab."""

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from math import dist
from typing import Annotated, Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
import numpy.typing as npt

from teachers.atoms import FN, FP, HN, HP, ActionClaim, Claim, Grounded, Moment, Scope, Verdict, claim, opposed, slot
from teachers.common import ChangeVerdict
from worlds.actions import inward
from worlds.optimization import Landscape, Optimization, Point, Truth

NumbersT = TypeVar("NumbersT", float, npt.NDArray[np.float64])
"""A number, or an array of them."""
NAMES = ("x1", "x2")
"""The coordinates."""
COURSES = tuple(f"{one} x1 and {other} x2" for one, other in product(("raise", "lower", "leave"), repeat=2))
"""Possible changes of both coordinates, in words."""
WAYS = {"raise": 1, "lower": -1}
"""The sign of each change of a coordinate."""


def proposed(lab: Optimization, truth: Truth, point: Point) -> float:
    """The loss that the simulator gives for a proposal."""
    lab.restore(truth)
    lab.step(point)
    return lab.truth.y


def succeeds(lab: Optimization, truth: Truth, point: Point) -> bool:
    """Whether a proposal solves the task."""
    lab.restore(truth)
    return bool(lab.step(point)[4]["success"])


def takes(lab: Optimization, truth: Truth, point: Point, before: float, after: float) -> bool:
    """Whether a proposal takes the loss from `before` to `after`."""
    return proposed(lab, truth, truth.x) == before and proposed(lab, truth, point) == after


def contains(lab: Optimization, point: Point) -> bool:
    """Whether a point is in the domain."""
    return all(low <= x <= high for low, x, high in zip(lab.lows, point, lab.highs, strict=True))


def format_point(point: Point) -> str:
    """A point as text."""
    return f"[{point[0]!r}, {point[1]!r}]"


def directions(x: Point, point: Point) -> str:
    """The directions from `x` to a point, in words."""
    (a1, a2), (b1, b2) = x, point
    way1 = "raise" if b1 > a1 else "lower" if b1 < a1 else "leave"
    way2 = "raise" if b2 > a2 else "lower" if b2 < a2 else "leave"
    return f"{way1} x1 and {way2} x2"


def with_coordinate(x: Point, i: int, value: float) -> Point:
    """The point with another value of one coordinate."""
    return (x[0], value) if i else (value, x[1])


def between(a: tuple[NumbersT, NumbersT], b: tuple[NumbersT, NumbersT], share: float) -> tuple[NumbersT, NumbersT]:
    """The point at this share of the way from `a` to `b`, elementwise for arrays."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def moved_inside(lab: Optimization, point: Point) -> Point:
    """The point with six significant digits, moved into the domain."""
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    x1, x2 = float(f"{point[0]:.6g}") + 0.0, float(f"{point[1]:.6g}") + 0.0  # without a negative zero
    if low1 <= x1 <= high1 and low2 <= x2 <= high2:
        return x1, x2
    x1, x2 = low1 if x1 < low1 else min(x1, high1), low2 if x2 < low2 else min(x2, high2)
    return x1 + 0.0, x2 + 0.0


def corners_of(lab: Optimization) -> tuple[Point, ...]:
    """The corners of the domain, the lowest first and the highest last."""
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    return (low1, low2), (low1, high2), (high1, low2), (high1, high2)


def grid(lab: Optimization) -> Iterator[Point]:
    """Points all over the domain, its corners included."""
    low, high = corners_of(lab)[0], corners_of(lab)[-1]
    for i in range(_SIDE):
        for j in range(_SIDE):
            x1, x2 = between(low, high, i / (_SIDE - 1))[0], between(low, high, j / (_SIDE - 1))[1]
            yield min(x1, high[0]), min(x2, high[1])


def minimiser_of(lab: Optimization, truth: Truth) -> Point:
    """A point of least loss."""
    return Landscape(lab.loss, truth.shift).minimisers()[0]


_FOUND: WeakKeyDictionary[Optimization, dict[Point, tuple[Point, ...]]] = WeakKeyDictionary()  # of the last shifts


def minima(lab: Optimization, truth: Truth) -> tuple[Point, ...]:
    """The points of least loss, found by proposals alone, by descent from all points of a grid."""
    known = _FOUND.setdefault(lab, {})
    if truth.shift not in known:
        if len(known) >= _KEPT:
            known.clear()
        ends = {end: proposed(lab, truth, end) for end in (_lowest_near(lab, truth, point) for point in grid(lab))}
        least = min(ends.values())
        known[truth.shift] = tuple(end for end, loss in ends.items() if loss - least <= _EQUAL)
    return known[truth.shift]


def _lowest_near(lab: Optimization, truth: Truth, start: Point) -> Point:
    """The end of a descent; on the border of the domain, where a triangle collapses to a line, of a second one."""
    end = _descend(lab, truth, start, 1 / (_SIDE - 1))
    return _descend(lab, truth, end, 1e-3) if {*end} & {*lab.lows, *lab.highs} else end


def _descend(lab: Optimization, truth: Truth, start: Point, size: float) -> Point:
    """A local minimum of the loss, from a triangle with this share of the sides of the domain."""
    from scipy.optimize import minimize  # slow to import

    spans = zip(start, lab.lows, lab.highs, strict=True)
    one, two = (x + (high - low) * size * (1 if 2 * x < low + high else -1) for x, low, high in spans)
    found = minimize(
        lambda x: proposed(lab, truth, (float(x[0]), float(x[1]))),
        start,
        method="Nelder-Mead",
        bounds=list(zip(lab.lows, lab.highs, strict=True)),
        options={"initial_simplex": [start, (one, start[1]), (start[0], two)], "xatol": 1e-7, "fatol": 1e-10},
    )
    return float(found.x[0]), float(found.x[1])


_KEPT = 16
_EQUAL = 1e-7  # of two losses that are the least: what `_descend` may leave
_SLACK = 1e-4  # of a side of the domain: where `minima` may be
_SIDE = 9
FARTHER = 1000
"""Number of points to try in the next quarter of a way."""


@claim
class Goal(Claim[Truth, Optimization]):
    """True if the task is solved by proposals whose loss is within `tolerance` of the least one, and by no others."""

    tolerance: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose points on a grid and near a point of least loss."""
        truth = moment.after
        points = list(grid(lab))
        best = minimiser_of(lab, truth)
        points += [between(best, point, share) for point in points for share in (0.0, 1e-3, 1e-2, 0.05)]
        lab.restore(truth)
        least = min(proposed(lab, truth, point) for point in points)
        return all(succeeds(lab, truth, p) == (proposed(lab, truth, p) - least <= self.tolerance) for p in points)


@claim
class Proposals(Claim[Truth, Optimization]):
    """True if every action proposes a point, whose loss is then seen."""

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose points on a grid and look at the observation."""
        for point in grid(lab):
            lab.restore(moment.after)
            observation = lab.advance(point)[0]
            if tuple(observation["x"].tolist()) != point or observation["y"].tolist() != [lab.truth.y]:
                return False
        return True


@claim
class Answer(Claim[Truth, Optimization]):
    """True if points are to be written so, and x1 and x2 have these bounds, which may be rounded, but inward only."""

    low1: float
    high1: float
    low2: float
    high2: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Offer the world the corners, points outside, and texts."""
        lab.restore(moment.after)
        box = lab.action_space
        inside = [[self.low1, self.low2], [self.high1, self.high2]]
        past1, past2 = (
            min(1e-5 * max(abs(low), abs(high)), (high - low) / 50)
            for low, high in ((self.low1, self.high1), (self.low2, self.high2))
        )
        outside = [[self.low1 - past1, self.low2], [self.high1 + past1, self.high2]]
        outside += [[self.low1, self.low2 - past2], [self.high1, self.high2 + past2]]
        return (
            all(box.contains(np.array(point)) for point in inside)
            and not any(box.contains(np.array(point)) for point in outside)
            and all(lab.read(f"x = [{x1!r}, {x2!r}]") == (x1, x2) for x1, x2 in inside)
            and lab.read("stay") == moment.after.x
        )


@claim
class _Targeted(ActionClaim[Truth, Optimization]):
    """Base of claims whose phrases name the point."""

    action_slot = "target"
    action: Point
    target = slot(format_point, "action")


@claim
class _Tried(Verdict[Truth, Optimization], _Targeted):
    """Base of verdicts on a proposal that the oracle tried at the start."""

    tried = True
    before: float
    after: float

    def applies(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose it."""
        return self.after != self.before and takes(lab, moment.after, self.action, self.before, self.after)

    def good(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Compare the losses."""
        return self.after < self.before


@claim
class TriedWell(_Tried):
    """True if proposing `action` at the start takes the loss down from `before` to `after`."""

    kind = HP


@claim
class TriedInVain(_Tried):
    """True if proposing `action` at the start takes the loss up from `before` to `after`."""

    kind = HN


opposed(TriedWell, TriedInVain)


@claim
class Solution(_Targeted):
    """True if no point has a smaller loss than `action`, which has `loss`."""

    loss: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose it, and many points far from it and close to it."""
        truth, points = moment.after, list(grid(lab))
        points += [between(self.action, point, share) for point in points for share in (1e-4, 1e-2, 0.1)]
        y = proposed(lab, truth, self.action)
        slack = 1e-9 * (1 + abs(y))  # the minimiser of a user's loss is found by a search
        return y == self.loss and all(proposed(lab, truth, p) >= y - slack for p in points)


@claim
class Reached(ActionClaim[Truth, Optimization]):
    """True if the proposal solved the task: its loss is within the tolerance of the least one."""

    kind = HP
    action_slot = ""  # the phrases name losses only
    action: Point
    loss: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose it again."""
        return (
            moment.before is not None
            and moment.action == self.action
            and succeeds(lab, moment.before, self.action)
            and lab.truth.y == self.loss
        )

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Claim that the loss rose."""
        return (Rose(action=self.action, before=self.loss, after=self.loss + abs(self.loss) + 1.0),)


@claim
class _Moved(ChangeVerdict[Truth, Optimization], ActionClaim[Truth, Optimization]):
    """Base of verdicts on the change of the loss."""

    action_slot = ""  # the phrases name losses only
    action: Point
    before: float
    after: float

    def applies(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Make both proposals again."""
        truth = moment.before
        return (
            truth is not None
            and moment.action == self.action
            and self.after != self.before
            and takes(lab, truth, self.action, self.before, self.after)
        )


@claim
class Fell(_Moved):
    """True if the proposal took the loss down from `before` to `after`."""

    kind = HP


@claim
class Rose(_Moved):
    """True if the proposal took the loss up from `before` to `after`."""

    kind = HN


opposed(Fell, Rose)


@claim
class _Changed(ChangeVerdict[Truth, Optimization]):
    """Base of verdicts on the change of one coordinate alone."""

    name: Annotated[str, NAMES]
    """`x1` or `x2`."""
    start: float
    end: float
    before: float
    """The loss at the point that the proposal left."""
    after: float
    """The loss with only this coordinate changed."""

    def applies(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose the old point with this coordinate changed."""
        truth = moment.before
        if truth is None or self.after == self.before:
            return False
        i = NAMES.index(self.name)
        if (truth.x[i], moment.action[i]) != (self.start, self.end):
            return False
        return takes(lab, truth, with_coordinate(truth.x, i, self.end), self.before, self.after)


@claim
class Helped(_Changed):
    """True if the proposal changed this coordinate so, and that alone takes the loss down from `before` to `after`."""

    kind = HP


@claim
class Hurt(_Changed):
    """True if the proposal changed this coordinate so, and that alone takes the loss up from `before` to `after`."""

    kind = HN


opposed(Helped, Hurt)


@claim
class _Course(_Targeted):
    """Base of advice whose phrases also name the directions."""

    ways: Annotated[str, COURSES]
    """The changes of the coordinates, such as `raise x1 and lower x2`."""
    now: float
    loss: float

    def leads(self, truth: Truth, lab: Optimization) -> bool:
        """Whether the directions and losses are right."""
        return self.ways == directions(truth.x, self.action) and takes(lab, truth, self.action, self.now, self.loss)


@claim
class Step(_Course):
    """True if proposing `action` takes the loss down from `now` to `loss`, and `ways` are the directions of it."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Make the step."""
        return self.loss < self.now and self.leads(moment.after, lab)

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Promise the same of the opposite direction and of the corners."""
        x = moment.after.x
        opposite = moved_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1]))
        return _steps((opposite, *corners_of(lab)), x, self.now, self.loss)

    def coarser(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """The quarter of the domain with the point, then the directions."""
        spans = zip(self.action, lab.lows, lab.highs, strict=True)
        (low1, high1), (low2, high2) = (
            inward(*((low + high) / 2, high) if x > (low + high) / 2 else (low, (low + high) / 2))
            for x, low, high in spans
        )
        area = Area.on(self, low1=low1, high1=high1, low2=low2, high2=high2, now=self.now)
        way = Way.on(self, ways=self.ways, now=self.now)
        return (area, way) if area.contains(self.action) else (way,)  # a point can lie in what was rounded off


@claim
class Area(Grounded[Truth, Optimization]):
    """True if a point within these bounds has a loss below `now`, which is that of the last proposal."""

    kind = FP
    low1: float
    high1: float
    low2: float
    high2: float
    now: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose the point of the ground."""
        return self.contains(self._ground.action) and self.now == moment.after.y and self.stands(moment, lab)

    def contains(self, point: Point) -> bool:
        """Whether a point is within the bounds."""
        return self.low1 <= point[0] <= self.high1 and self.low2 <= point[1] <= self.high2

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Look for such a point."""

        def inside(point: Point) -> bool:
            return self.low1 <= point[0] <= self.high1 and self.low2 <= point[1] <= self.high2

        return self.now == moment.after.y and _improves(moment, oracle, inside)


@claim
class Way(Grounded[Truth, Optimization]):
    """True if a point in these directions has a loss below `now`, which is that of the last proposal."""

    kind = FP
    ways: Annotated[str, COURSES]
    """The changes of the coordinates, such as `raise x1 and lower x2`."""
    now: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose the point of the ground."""
        directed = self.ways == directions(moment.after.x, self._ground.action)
        return directed and self.now == moment.after.y and self.stands(moment, lab)

    def means(self, moment: Moment[Truth], oracle: Any) -> bool:
        """Look for such a point."""
        x = moment.after.x
        return self.now == moment.after.y and _improves(moment, oracle, lambda p: directions(x, p) == self.ways)


@claim
class Cross(_Course):
    """True if proposing `action` does not take the loss down from `now`, but going farther that way would.

    Farther means up to a quarter of the way more. `ways` are the directions, `loss` is what the proposal gives.
    """

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Make the step, and longer ones."""
        truth = moment.after
        farther = (between(truth.x, self.action, 1 + i / FARTHER / 4) for i in range(1, FARTHER + 1))
        return (
            self.loss >= self.now
            and self.leads(truth, lab)
            and any(proposed(lab, truth, p) < self.now for p in farther if contains(lab, p))
        )

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Send the student to a corner."""
        return _steps(corners_of(lab), moment.after.x, moment.after.y, moment.after.y - 1.0)


@claim
class Stay(_Targeted):
    """True if the last proposal, `action`, solves the task, and so would the same once more."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose it once more."""
        return self.action == moment.after.x and succeeds(lab, moment.after, self.action)

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Send the student to a corner."""
        return _steps(corners_of(lab), moment.after.x, moment.after.y, moment.after.y - 1.0)


@claim
class Avoid(_Targeted):
    """True if proposing `action` takes the loss up from `now` to `loss`."""

    kind = FN
    now: float
    loss: float

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Propose it."""
        return self.loss > self.now and takes(lab, moment.after, self.action, self.now, self.loss)

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Warn of the opposite direction and of the middle of the domain."""
        x = moment.after.x
        low, high = corners_of(lab)[0], corners_of(lab)[-1]
        points = [moved_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1])), between(low, high, 0.5)]
        return tuple(Avoid(action=point, now=self.now, loss=self.loss) for point in points if point != self.action)


@claim
class _Span(Claim[Truth, Optimization]):
    """Base of claims about the places of points of least loss."""

    scope = Scope.WORLD
    name: Annotated[str, NAMES]
    """`x1` or `x2`."""
    low: float
    high: float

    def inside(self, moment: Moment[Truth], lab: Optimization, slack: float) -> bool:
        """Whether some point of least loss is within the bounds, or up to `slack` of a side of the domain outside."""
        i = NAMES.index(self.name)
        slack *= lab.highs[i] - lab.lows[i]
        return any(self.low - slack <= point[i] <= self.high + slack for point in minima(lab, moment.after))

    def counterparts(self, moment: Moment[Truth], lab: Optimization) -> Sequence[Claim]:
        """Other bounds, as far apart."""
        i, width = NAMES.index(self.name), self.high - self.low
        spans = ((low, low + width) for low in (lab.lows[i], lab.highs[i] - width))
        spans = (inward(max(low, lab.lows[i]), min(high, lab.highs[i])) for low, high in spans)
        return tuple(type(self)(name=self.name, low=low, high=high) for low, high in spans if low != self.low)


@claim
class NoneBetween(_Span):
    """True if at no point of least loss this coordinate is between these bounds."""

    kind = FN

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Search by proposals."""
        return not self.inside(moment, lab, -_SLACK)


@claim
class Between(_Span):
    """True if at some point of least loss this coordinate is between these bounds."""

    kind = FP

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Search by proposals."""
        return self.inside(moment, lab, _SLACK)

    def excludes(self, other: Claim) -> bool:
        """A claim that it is not between bounds that enclose these."""
        if not isinstance(other, NoneBetween) or other.name != self.name:
            return False
        return other.low <= self.low and self.high <= other.high


@claim
class Along(Claim[Truth, Optimization]):
    """True if some point of least loss has a greater value of this coordinate than the last proposal, or a smaller one.

    It is greater if `way` is `raise`, and smaller if it is `lower`.
    """

    kind = FP
    name: Annotated[str, NAMES]
    way: Annotated[str, (*WAYS,)]
    counterparts = Claim.varied("way", WAYS)

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Search by proposals."""
        i, sign = NAMES.index(self.name), WAYS[self.way]
        return any(sign * (point[i] - moment.after.x[i]) > 0 for point in minima(lab, moment.after))


@claim
class Near(Claim[Truth, Optimization]):
    """True if some point of least loss is no farther than `radius` from the last proposal."""

    kind = FP
    radius: float
    counterparts = Claim.varied("radius", lambda claim, _, __: (claim.radius / 5, claim.radius / 10))

    def holds(self, moment: Moment[Truth], lab: Optimization) -> bool:
        """Search by proposals."""
        slack = _SLACK * dist(lab.lows, lab.highs)
        return any(dist(moment.after.x, point) <= self.radius + slack for point in minima(lab, moment.after))


def _improves(moment: Moment[Truth], oracle: Any, fits: Callable[[Point], bool]) -> bool:
    """Whether a fitting point has a loss below the last: an advised point, the minimiser, or a point of a grid."""
    truth, lab = moment.after, oracle.lab
    advised = [each.action for each in oracle.judge(moment, {FP}) if isinstance(each, _Targeted)]
    points = (*advised, minimiser_of(lab, truth), *grid(lab))
    return any(fits(point) and proposed(lab, truth, point) < truth.y for point in points)


def _steps(points: Sequence[Point], x: Point, now: float, loss: float) -> tuple[Step, ...]:
    return tuple(Step(action=p, ways=directions(x, p), now=now, loss=loss) for p in points if p != x)
