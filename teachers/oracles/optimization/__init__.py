"""The oracle of losses: it knows their derivatives and where they are least, and tries out what it says."""

import math
from collections.abc import Iterator, Sequence, Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Grounded, Moment, claim
from teachers.oracle import Oracle
from worlds.optimization import TOLERANCE, Landscape, Point, Truth
from worlds.world import World


@claim
class Goal(Claim):
    """True if the task is solved by proposals whose loss is within `tolerance` of the least one, and by no others."""

    tolerance: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose points on a grid and near a point of least loss."""
        truth = moment.after
        points = list(_grid(lab))
        best = _best(lab, truth)
        points += [_between(best, point, share) for point in points for share in (0.0, 1e-3, 1e-2, 0.05)]
        lab.restore(truth)
        least = min(_proposed(lab, truth, point) for point in points)
        return all(_succeeds(lab, truth, p) == (_proposed(lab, truth, p) - least <= self.tolerance) for p in points)


@claim
class Proposals(Claim):
    """True if every action proposes a point, whose loss is then seen."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose points on a grid and look at the observation."""
        for point in _grid(lab):
            lab.restore(moment.after)
            observation = lab.advance(point)[0]
            if tuple(observation["x"].tolist()) != point or observation["y"].tolist() != [lab.truth.y]:
                return False
        return True


@claim
class Answer(Claim):
    """True if points are to be written so, and x1 and x2 have these bounds."""

    low1: float
    high1: float
    low2: float
    high2: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Offer the world the corners, points outside, and texts."""
        lab.restore(moment.after)
        box = lab.action_space
        inside = [[self.low1, self.low2], [self.high1, self.high2]]
        outside = [[self.low1 - 1e-3, self.low2], [self.high1 + 1e-3, self.high2]]
        outside += [[self.low1, self.low2 - 1e-3], [self.high1, self.high2 + 1e-3]]
        return (
            all(box.contains(np.array(point)) for point in inside)
            and not any(box.contains(np.array(point)) for point in outside)
            and all(lab.read(f"x = [{x1!r}, {x2!r}]") == (x1, x2) for x1, x2 in inside)
            and lab.read("stay") == moment.after.x
        )


@claim
class TriedWell(Claim):
    """True if proposing `action` at the start takes the loss down from `before` to `after`."""

    kind = HP
    action: Point
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        return _tried(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedInVain(action=self.action, target=self.target, before=self.before, after=self.after),)


@claim
class TriedInVain(Claim):
    """True if proposing `action` at the start takes the loss up from `before` to `after`."""

    kind = HN
    action: Point
    target: str
    """The action as text."""
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        return _tried(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (TriedWell(action=self.action, target=self.target, before=self.before, after=self.after),)


@claim
class Solution(Claim):
    """True if no point has a smaller loss than `action`, which has `loss`."""

    action: Point
    target: str
    """The action as text."""
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it, and many points far from it and close to it."""
        truth, points = moment.after, list(_grid(lab))
        points += [_between(self.action, point, share) for point in points for share in (1e-4, 1e-2, 0.1)]
        y = _proposed(lab, truth, self.action)
        slack = 1e-9 * (1 + abs(y))  # the minimiser of a user's loss is found by a search
        return _target(self) and y == self.loss and all(_proposed(lab, truth, p) >= y - slack for p in points)


@claim
class Reached(Claim):
    """True if the proposal solved the task: its loss is within the tolerance of the least one."""

    kind = HP
    action: Point
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it again."""
        return (
            moment.before is not None
            and moment.action == self.action
            and _succeeds(lab, moment.before, self.action)
            and lab.truth.y == self.loss
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Speak of a loss that rose."""
        return (Rose(action=self.action, before=self.loss, after=self.loss + abs(self.loss) + 1.0),)


@claim
class Fell(Claim):
    """True if the proposal took the loss down from `before` to `after`."""

    kind = HP
    action: Point
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make both proposals again."""
        return _moved(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Rose(action=self.action, before=self.after, after=self.before),)


@claim
class Rose(Claim):
    """True if the proposal took the loss up from `before` to `after`."""

    kind = HN
    action: Point
    before: float
    after: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make both proposals again."""
        return _moved(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Fell(action=self.action, before=self.after, after=self.before),)


@claim
class Helped(Claim):
    """True if the proposal changed this coordinate so, and that change alone takes the loss down as told."""

    kind = HP
    name: str
    """`x1` or `x2`."""
    start: float
    end: float
    before: float
    """The loss at the point that the proposal left."""
    after: float
    """The loss with only this coordinate changed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the old point with this coordinate changed."""
        return _changed(self, moment, lab) and self.after < self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Hurt(name=self.name, start=self.start, end=self.end, before=self.after, after=self.before),)


@claim
class Hurt(Claim):
    """True if the proposal changed this coordinate so, and that change alone takes the loss up as told."""

    kind = HN
    name: str
    """`x1` or `x2`."""
    start: float
    end: float
    before: float
    """The loss at the point that the proposal left."""
    after: float
    """The loss with only this coordinate changed."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the old point with this coordinate changed."""
        return _changed(self, moment, lab) and self.after > self.before

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The opposite verdict."""
        return (Helped(name=self.name, start=self.start, end=self.end, before=self.after, after=self.before),)


@claim
class Step(Claim):
    """True if proposing `action` takes the loss down from `now` to `loss`, and `ways` are the directions of it."""

    kind = FP
    action: Point
    target: str
    """The action as text."""
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the step."""
        truth = moment.after
        return (
            _target(self)
            and self.ways == _ways(truth.x, self.action)
            and _proposed(lab, truth, truth.x) == self.now
            and _proposed(lab, truth, self.action) == self.loss < self.now
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Promise the same of the opposite direction and of the corners."""
        x = moment.after.x
        points = (_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1])), *_corners(lab))
        return tuple(_step_to(point, x, self.now, self.loss) for point in points if point != x)

    def coarser(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """The quarter of the domain in which the point lies, then the directions."""
        spans = zip(self.action, lab.lows, lab.highs, strict=True)
        (low1, high1), (low2, high2) = (
            ((low + high) / 2, high) if x > (low + high) / 2 else (low, (low + high) / 2) for x, low, high in spans
        )
        area = Area.on(self, low1=low1, high1=high1, low2=low2, high2=high2, now=self.now)
        return area, Way.on(self, ways=self.ways, now=self.now)


@claim
class Area(Grounded):
    """True if a point within these bounds has a loss below `now`, which is that of the last proposal."""

    kind = FP
    low1: float
    high1: float
    low2: float
    high2: float
    now: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the point that the ground knows."""
        x1, x2 = self._ground.action
        inside = self.low1 <= x1 <= self.high1 and self.low2 <= x2 <= self.high2
        return inside and self.now == moment.after.y and self.stands(moment, lab)


@claim
class Way(Grounded):
    """True if a point in these directions has a loss below `now`, which is that of the last proposal."""

    kind = FP
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose the point that the ground knows."""
        directed = self.ways == _ways(moment.after.x, self._ground.action)
        return directed and self.now == moment.after.y and self.stands(moment, lab)


@claim
class Cross(Claim):
    """True if proposing `action` does not take the loss down from `now`, but going farther that way would.

    Farther means up to a quarter of the way more. `ways` are the directions, `loss` is what the proposal gives.
    """

    kind = FP
    action: Point
    target: str
    """The action as text."""
    ways: str
    """What becomes of the coordinates, such as `raise x1 and lower x2`."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Make the step, and longer ones."""
        truth = moment.after
        farther = (_between(truth.x, self.action, 1 + i / _FARTHER / 4) for i in range(1, _FARTHER + 1))
        return (
            _target(self)
            and self.ways == _ways(truth.x, self.action)
            and _proposed(lab, truth, truth.x) == self.now
            and _proposed(lab, truth, self.action) == self.loss >= self.now
            and any(_proposed(lab, truth, p) < self.now for p in farther if _contains(lab, p))
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the student to a corner."""
        x, y = moment.after.x, moment.after.y
        return tuple(_step_to(point, x, y, y - 1.0) for point in _corners(lab) if point != x)


@claim
class Stay(Claim):
    """True if the last proposal, `action`, solves the task, and so would the same once more."""

    kind = FP
    action: Point
    target: str
    """The action as text."""

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it once more."""
        return _target(self) and self.action == moment.after.x and _succeeds(lab, moment.after, self.action)

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Send the student to a corner."""
        x, y = moment.after.x, moment.after.y
        return tuple(_step_to(point, x, y, y - 1.0) for point in _corners(lab) if point != x)


@claim
class Avoid(Claim):
    """True if proposing `action` takes the loss up from `now` to `loss`."""

    kind = FN
    action: Point
    target: str
    """The action as text."""
    now: float
    loss: float

    def holds(self, moment: Moment, lab: World) -> bool:
        """Propose it."""
        truth = moment.after
        return (
            _target(self)
            and _proposed(lab, truth, truth.x) == self.now
            and _proposed(lab, truth, self.action) == self.loss > self.now
        )

    def counterparts(self, moment: Moment, lab: World) -> Sequence[Claim]:
        """Warn of the opposite direction and of the middle of the domain."""
        x = moment.after.x
        low, high = _corners(lab)[0], _corners(lab)[-1]
        points = [_inside(lab, (2 * x[0] - self.action[0], 2 * x[1] - self.action[1])), _between(low, high, 0.5)]
        return tuple(_avoid(point, self.now, self.loss) for point in points if point != self.action)


def _proposed(lab: World, truth: Truth, point: Point) -> float:
    """The loss that the simulator gives for a proposal."""
    lab.restore(truth)
    lab.step(point)
    return lab.truth.y


def _succeeds(lab: World, truth: Truth, point: Point) -> bool:
    lab.restore(truth)
    return lab.step(point)[4]["success"]


def _contains(lab: World, point: Point) -> bool:
    return all(low <= x <= high for low, x, high in zip(lab.lows, point, lab.highs, strict=True))


def _tried(said: TriedWell | TriedInVain, moment: Moment, lab: World) -> bool:
    truth = moment.after
    return (
        _target(said)
        and _proposed(lab, truth, truth.x) == said.before
        and _proposed(lab, truth, said.action) == said.after
    )


def _moved(said: Fell | Rose, moment: Moment, lab: World) -> bool:
    before = moment.before
    return (
        before is not None
        and moment.action == said.action
        and _proposed(lab, before, before.x) == said.before
        and _proposed(lab, before, said.action) == said.after
    )


def _changed(said: Helped | Hurt, moment: Moment, lab: World) -> bool:
    before = moment.before
    if before is None:
        return False
    i = _NAMES.index(said.name)
    return (
        (before.x[i], moment.action[i]) == (said.start, said.end)
        and _proposed(lab, before, before.x) == said.before
        and _proposed(lab, before, _with(before.x, i, said.end)) == said.after
    )


def _target(said: TriedWell | TriedInVain | Solution | Step | Cross | Stay | Avoid) -> bool:
    """Whether the text of a claim's action is that action."""
    return tuple(map(float, said.target.strip("[]").split(", "))) == said.action


def _write(point: Point) -> str:
    return f"[{point[0]!r}, {point[1]!r}]"


def _ways(x: Point, point: Point) -> str:
    """The directions from one point to another, in words."""
    (a1, a2), (b1, b2) = x, point
    way1 = "raise" if b1 > a1 else "lower" if b1 < a1 else "leave"
    way2 = "raise" if b2 > a2 else "lower" if b2 < a2 else "leave"
    return f"{way1} x1 and {way2} x2"


def _with(x: Point, i: int, value: float) -> Point:
    return (x[0], value) if i else (value, x[1])


def _between(a: Point, b: Point, share: float) -> Point:
    """The point that lies this share of the way from `a` to `b`."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def _inside(lab: World, point: Point) -> Point:
    """The point with six significant digits, moved into the domain."""
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    x1, x2 = float(f"{point[0]:.6g}") + 0.0, float(f"{point[1]:.6g}") + 0.0  # without a negative zero
    if low1 <= x1 <= high1 and low2 <= x2 <= high2:
        return x1, x2
    return min(max(x1, low1), high1) + 0.0, min(max(x2, low2), high2) + 0.0


def _corners(lab: World) -> tuple[Point, ...]:
    (low1, low2), (high1, high2) = lab.lows, lab.highs
    return (low1, low2), (low1, high2), (high1, low2), (high1, high2)


def _grid(lab: World) -> Iterator[Point]:
    """Points all over the domain, its corners included."""
    low, high = _corners(lab)[0], _corners(lab)[-1]
    for i in range(_SIDE):
        for j in range(_SIDE):
            x1, x2 = _between(low, high, i / (_SIDE - 1))[0], _between(low, high, j / (_SIDE - 1))[1]
            yield min(x1, high[0]), min(x2, high[1])


def _best(lab: World, truth: Truth) -> Point:
    return Landscape(lab.loss, truth.shift).minimisers()[0]


def _step_to(point: Point, x: Point, now: float, loss: float) -> Step:
    return Step(action=point, target=_write(point), ways=_ways(x, point), now=now, loss=loss)


def _avoid(point: Point, now: float, loss: float) -> Avoid:
    return Avoid(action=point, target=_write(point), now=now, loss=loss)


def _differ(a: float, b: float) -> bool:
    """Whether two losses differ in the six digits that phrases tell."""
    a, b, gap = abs(a), abs(b), abs(a - b)
    return gap > 1e-5 * (a if a > b else b)


def _newton(gradient: Sequence[float], hessian: Sequence[float]) -> Point:
    """Newton's step, with the curvature raised to be positive in every direction."""
    g1, g2 = gradient
    h11, h12, h22 = hessian
    mean, radius = (h11 + h22) / 2, math.hypot((h11 - h22) / 2, h12)
    floor = 1e-3 * (abs(mean) + radius) + 1e-9
    extra = max(0.0, floor - (mean - radius))
    h11, h22 = h11 + extra, h22 + extra
    determinant = h11 * h22 - h12 * h12
    return (h12 * g2 - h22 * g1) / determinant, (h12 * g1 - h11 * g2) / determinant


_NAMES = ("x1", "x2")
_SIDE = 9
_FARTHER = 1000  # points that are tried in the next quarter of a way
_BEHIND = range(400, 500, 10)  # of these, the ones about a minimiser to which the way is nine tenths gone
_TRIES = 3
_SHORT = 0.9  # the greatest share of the way to a minimiser that advice goes
_SHARES = (_SHORT, 0.8, 0.6, 0.4, 0.2)
_ENOUGH = 0.1  # Newton's step is taken if it leaves no more than this share of the loss that can be saved
_CLOSE = 1e-6
_PROPOSALS = Proposals()


class OptimizationOracle(Oracle):
    """Judges proposals by what the loss did, and advises points whose loss it has looked up.

    The advised point is a Newton step, with the exact gradient and curvature, if that saves nine tenths of the loss
    that can be saved. Where it does not, as in the basin of a lesser minimum, the oracle uses what else it knows:
    the point lies on the way to the nearest minimiser. Either stops at nine tenths of that way: the minimiser itself is
    told by the instruction `c` only.
    """

    def start(self, truth: Truth, rng: np.random.Generator) -> None:
        """Look at the loss as it is shifted in this episode."""
        super().start(truth, rng)
        self._landscape = Landscape(self.lab.loss, truth.shift)
        self._minimisers = self._landscape.minimisers()
        self._minimum = self.lab.minimum

    @property
    def max_importance(self) -> float:  # type: ignore[override]
        """The greatest reward less the least: each loss has its own."""
        low, high = self.lab.reward_range
        return high - low

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        (low1, low2), (high1, high2) = self.lab.lows, self.lab.highs
        return Goal(tolerance=TOLERANCE), _PROPOSALS, Answer(low1=low1, high1=high1, low2=low2, high2=high2)

    def _practice(self, truth: Truth) -> tuple[Claim, ...]:
        """A few random proposals, tried at the start."""
        told: list[Claim] = []
        for _ in range(_TRIES):
            action = _inside(self.lab, self.lab.sample_action(self.rng).tolist())
            self.lab.restore(truth)
            self.lab.advance(action)
            after = self.lab.truth.y
            if _differ(after, truth.y):
                verdict = TriedWell if after < truth.y else TriedInVain
                told.append(verdict(action=action, target=_write(action), before=truth.y, after=after))
        return tuple(told)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        action = self._nearest(truth.x)
        return (Solution(action=action, target=_write(action), loss=self._landscape.value(*action)),)

    def _hindsight(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        """The verdict on the proposal, then those on what each coordinate did by itself; no change is no news."""
        x, before, _ = moment.before
        action, after = moment.action, moment.after.y
        good: list[Claim] = []
        bad: list[Claim] = []
        if moment.success:
            good.append(Reached(action=action, loss=after))
        elif _differ(before, after):
            if after < before:
                good.append(Fell(action=action, before=before, after=after))
            else:
                bad.append(Rose(action=action, before=before, after=after))
        for i, name in enumerate(_NAMES):
            if action[i] != x[i]:
                alone = self._landscape.value(*_with(x, i, action[i]))
                if _differ(before, alone):
                    told, verdict = (good, Helped) if alone < before else (bad, Hurt)
                    told.append(verdict(name=name, start=x[i], end=action[i], before=before, after=alone))
        if HP in kinds:
            claims += good
        if HN in kinds:
            claims += bad

    def _advice(self, claims: list[Claim], moment: Moment, kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        x, y, _ = truth
        good = None
        if y - self._minimum <= TOLERANCE:
            if FP in kinds:
                claims.append(Stay(action=x, target=_write(x)))
        else:
            good = self._step(truth)
            if FP in kinds and good:
                point, loss = good
                cls = Step if loss < y else Cross
                claims.append(cls(action=point, target=_write(point), ways=_ways(x, point), now=y, loss=loss))
        if FN in kinds:
            for point in self._warnings(x, good and good[0], moment.turn):
                loss = self._landscape.value(*point)
                if loss > y and _differ(loss, y):
                    claims.append(_avoid(point, y, loss))
                    break

    def _step(self, truth: Truth) -> tuple[Point, float] | None:
        """A point of less loss, with its loss, or where there is none one behind which the loss is less."""
        x, y, _ = truth
        landscape = self._landscape
        step = _newton(landscape.gradient(*x), landscape.hessian(*x))
        newton = self._short(x, (x[0] + step[0], x[1] + step[1]))
        if newton:
            loss = landscape.value(*newton)
            if loss - self._minimum <= _ENOUGH * (y - self._minimum):
                return newton, loss
        minimiser = self._nearest(x)
        for share in _SHARES:
            point = self._short(x, _between(x, minimiser, share))
            if point:
                loss = landscape.value(*point)
                if loss < y and _differ(loss, y):
                    return point, loss
        # Here a ridge has to be crossed, behind which the minimiser lies.
        point = self._short(x, _between(x, minimiser, _SHORT))
        if point:
            for i in _BEHIND:
                farther = _between(x, point, 1 + i / _FARTHER / 4)
                if _contains(self.lab, farther) and landscape.value(*farther) < y:
                    return point, landscape.value(*point)
        return None

    def _short(self, x: Point, point: Point) -> Point | None:
        """The point, in the domain, or one that is no closer to a minimiser than a tenth of the way from `x`."""
        point = _inside(self.lab, point)
        minimiser = self._nearest(point)
        if math.dist(point, minimiser) < (1 - _SHORT) * math.dist(x, minimiser):
            point = _inside(self.lab, _between(x, minimiser, _SHORT))
            minimiser = self._nearest(point)
        return point if math.dist(point, minimiser) > _CLOSE and point != x else None

    def _warnings(self, x: Point, good: Point | None, turn: int) -> Iterator[Point]:
        """Points whose loss may be higher: opposite to the good one, and the corners."""
        if good:
            yield _inside(self.lab, (2 * x[0] - good[0], 2 * x[1] - good[1]))
        corners = _corners(self.lab)
        for i in range(len(corners)):
            yield corners[(turn + i) % len(corners)]

    def _nearest(self, x: Point) -> Point:
        """The nearest point of least loss."""
        minimisers = self._minimisers
        return minimisers[0] if len(minimisers) == 1 else min(minimisers, key=lambda m: math.dist(x, m))

    def importance(self, truth: Truth) -> float:
        """The reward that can still be gained: that of a least loss, less that of proposing the same point again."""
        low, high = self.lab.reward_range
        return high - min(max(-truth.y / 100, low), high)

    def plan(self, truth: Truth, n: int) -> tuple[Point, ...]:
        """The nearest point of least loss, again and again."""
        return (self._nearest(truth.x),) * n

    def regret(self, moment: Moment) -> float:
        """The greatest reward less the action's; a turn without an action loses all that can be lost."""
        low, high = self.lab.reward_range
        return high - (low if moment.before is None else moment.reward)
