"""The oracle of losses: it uses their derivatives and minimisers, and evaluates the points that it names."""

import math
from collections.abc import Sequence, Set

import numpy as np

from teachers.atoms import FN, FP, HN, HP, Claim, FeedbackType, Moment, fast_constructor
from teachers.oracle import Oracle
from teachers.oracles.optimization.claims import (
    FARTHER,
    NAMES,
    Along,
    Answer,
    Avoid,
    Between,
    Cross,
    Fell,
    Goal,
    Helped,
    Hurt,
    Near,
    NoneBetween,
    Proposals,
    Reached,
    Rose,
    Solution,
    Stay,
    Step,
    TriedInVain,
    TriedWell,
    between,
    contains,
    corners_of,
    directions,
    moved_inside,
)
from worlds.actions import inward
from worlds.optimization import TOLERANCE, Landscape, Optimization, Point, Truth


def _differ(a: float, b: float) -> bool:
    """Whether two losses differ in the six digits that phrases show."""
    return not math.isclose(a, b, rel_tol=1e-5)


def _newton(gradient: Sequence[float], hessian: Sequence[float]) -> Point:
    """Newton's step, with the curvature raised to be positive in every direction."""
    g1, g2 = gradient
    h11, h12, h22 = hessian
    mean, radius = (h11 + h22) / 2, math.hypot((h11 - h22) / 2, h12)
    lack = 1e-3 * (abs(mean) + radius) + 1e-9 - (mean - radius)
    if lack > 0:
        h11, h22 = h11 + lack, h22 + lack
    determinant = h11 * h22 - h12 * h12
    return (h12 * g2 - h22 * g1) / determinant, (h12 * g1 - h11 * g2) / determinant


BEHIND = range(400, 500, 10)
"""Indices into `FARTHER` of points around a minimiser, after nine tenths of the way to it."""
SHORT = 0.9
"""Largest share of the way to a minimiser in advice."""
SHARES = (SHORT, 0.8, 0.6, 0.4, 0.2)
"""Shares of that way to try if Newton's step is not good enough."""
ENOUGH = 0.1
"""Newton's step is good enough if it leaves at most this share of the loss that can be saved."""
CLOSE = 1e-6
"""Advice names no point within this distance of a minimiser."""
_EDGE = 1e-3
"""Clues skip minimisers within this share of a side from the edge of a part."""
_TRIES = 3
_PROPOSALS = Proposals()
_fell, _rose = fast_constructor(Fell), fast_constructor(Rose)
_helped, _hurt = fast_constructor(Helped), fast_constructor(Hurt)
_step, _cross, _avoid = fast_constructor(Step), fast_constructor(Cross), fast_constructor(Avoid)


class OptimizationOracle(Oracle[Truth, Optimization]):
    """Judges proposals by the change of the loss, and advises points whose loss it has computed.

    The advised point is a Newton step, with the exact gradient and curvature, if that saves nine tenths of the loss
    that can be saved. Otherwise, as in the basin of a local minimum, the point lies on the way to the nearest
    minimiser. Both stop at nine tenths of that way: only the instruction `c` names the minimiser itself.
    """

    def start(self, truth: Truth) -> None:
        """Find the minimisers of the loss as it is shifted in this episode."""
        self._landscape = Landscape(self.lab.loss, truth.shift)
        self._minimisers = self._landscape.minimisers()
        self._minimum = self.lab.minimum
        self._corners = corners_of(self.lab)

    @property
    def max_importance(self) -> float:  # type: ignore[override]
        """The greatest reward minus the least, of this loss."""
        low, high = self.lab.reward_range
        return high - low

    def _basics(self, truth: Truth) -> tuple[Claim, ...]:
        (low1, high1), (low2, high2) = map(inward, self.lab.lows, self.lab.highs)
        return Goal(tolerance=TOLERANCE), _PROPOSALS, Answer(low1=low1, high1=high1, low2=low2, high2=high2)

    def _practice(self, truth: Truth, rng: np.random.Generator) -> tuple[Claim, ...]:
        """A few random proposals, tried at the start."""
        claims: list[Claim] = []
        for _ in range(_TRIES):
            action = moved_inside(self.lab, self.lab.sample_action(rng).tolist())
            self.lab.restore(truth)
            self.lab.advance(action)
            after = self.lab.truth.y
            if _differ(after, truth.y):
                verdict = TriedWell if after < truth.y else TriedInVain
                claims.append(verdict(action=action, before=truth.y, after=after))
        return tuple(claims)

    def _solution(self, truth: Truth) -> tuple[Claim, ...]:
        action = self._nearest(truth.x)
        return (Solution(action=action, loss=self._landscape.value(*action)),)

    def _hindsight(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        """Judge the proposal, then each coordinate alone; no verdict if the loss does not change."""
        (x1, x2), before, _ = moment.past
        action, after = moment.action, moment.after.y
        good: list[Claim] = []
        bad: list[Claim] = []
        if moment.success:
            good.append(Reached(action=action, loss=after))
        elif _differ(before, after):
            if after < before:
                good.append(_fell(action, before, after))
            else:
                bad.append(_rose(action, before, after))
        value, (end1, end2) = self._landscape.value, action
        for name, start, end, alone in (("x1", x1, end1, value(end1, x2)), ("x2", x2, end2, value(x1, end2))):
            if end != start and _differ(before, alone):
                if alone < before:
                    good.append(_helped(name, start, end, before, alone))
                else:
                    bad.append(_hurt(name, start, end, before, alone))
        if HP in kinds:
            claims += good
        if HN in kinds:
            claims += bad

    def _advice(self, claims: list[Claim], moment: Moment[Truth], kinds: Set[FeedbackType]) -> None:
        truth = moment.after
        x, y, _ = truth
        good = None
        if y - self._minimum <= TOLERANCE:
            if FP in kinds:
                claims.append(Stay(action=x))
        else:
            good = self._step(truth)
            if FP in kinds and good:
                point, loss = good
                advise = _step if loss < y else _cross
                claims.append(advise(point, directions(x, point), y, loss))
        if FN in kinds:
            for point in self._suspects(x, good and good[0], moment.turn):
                loss = self._landscape.value(*point)
                if loss > y and _differ(loss, y):
                    claims.append(_avoid(point, y, loss))
                    break

    def clues(self, truth: Truth) -> tuple[Claim, ...]:
        """A half of the domain without a minimiser; a half with one; its direction and distance; eighths with it."""
        x, y, _ = truth
        if y - self._minimum <= TOLERANCE:
            return ()
        lows, highs, best = self.lab.lows, self.lab.highs, self._nearest(x)
        sides = [high - low for low, high in zip(lows, highs, strict=True)]
        middle = lows[0] + sides[0] / 2
        halves, edge = ((lows[0], middle), (middle, highs[0])), _EDGE * sides[0]
        empty = [h for h in halves if not any(h[0] - edge <= m[0] <= h[1] + edge for m in self._minimisers)]
        spans = [inward(*half) for half in empty]
        clues: list[Claim] = [NoneBetween(name=NAMES[0], low=low, high=high) for low, high in spans]
        clues += self._around(1, best, 2)
        away, i = max((abs(best[i] - x[i]) / sides[i], i) for i in range(2))
        if away > _EDGE:
            clues.append(Along(name=NAMES[i], way="raise" if best[i] > x[i] else "lower"))
        far = math.dist(x, best)
        unit = 10 ** math.floor(math.log10(far))
        clues.append(Near(radius=float(f"{next(n * unit for n in (2, 5, 10) if n * unit >= far):.1g}")))
        return (*clues, *self._around(0, best, 8), *self._around(1, best, 8))

    def _around(self, i: int, best: Point, parts: int) -> tuple[Between, ...]:
        """The part of a side of the domain with a point, of `parts` parts; empty if the point is on the part's edge."""
        low, high = self.lab.lows[i], self.lab.highs[i]
        width = (high - low) / parts
        part = min(math.floor((best[i] - low) / width), parts - 1)
        ends = low + part * width, low + (part + 1) * width
        if any(abs(best[i] - end) < _EDGE * (high - low) and end not in (low, high) for end in ends):
            return ()
        begin, end = inward(ends[0], min(ends[1], high))
        return (Between(name=NAMES[i], low=begin, high=end),)

    def _step(self, truth: Truth) -> tuple[Point, float] | None:
        """A point of less loss, with its loss; if there is none, a point on the way to less loss."""
        x, y, _ = truth
        landscape = self._landscape
        step = _newton(landscape.gradient(*x), landscape.hessian(*x))
        newton = self._short(x, (x[0] + step[0], x[1] + step[1]))
        if newton:
            loss = landscape.value(*newton)
            if loss - self._minimum <= ENOUGH * (y - self._minimum):
                return newton, loss
        minimiser = self._nearest(x)
        for share in SHARES:
            point = self._short(x, between(x, minimiser, share))
            if point:
                loss = landscape.value(*point)
                if loss < y and _differ(loss, y):
                    return point, loss
        # Here a ridge has to be crossed, behind which the minimiser lies.
        point = self._short(x, between(x, minimiser, SHORT))
        if point:
            for i in BEHIND:
                farther = between(x, point, 1 + i / FARTHER / 4)
                if contains(self.lab, farther) and landscape.value(*farther) < y:
                    return point, landscape.value(*point)
        return None

    def _short(self, x: Point, point: Point) -> Point | None:
        """The point in the domain, moved back if it is closer to a minimiser than a tenth of the way from `x`."""
        point = moved_inside(self.lab, point)
        minimiser = self._nearest(point)
        if math.dist(point, minimiser) < (1 - SHORT) * math.dist(x, minimiser):
            point = moved_inside(self.lab, between(x, minimiser, SHORT))
            minimiser = self._nearest(point)
        return point if math.dist(point, minimiser) > CLOSE and point != x else None

    def _suspects(self, x: Point, good: Point | None, turn: int) -> tuple[Point, ...]:
        """Points whose loss may be higher: opposite to the good point, and the corners."""
        first = turn % len(self._corners)
        corners = self._corners[first:] + self._corners[:first]
        if good is None:
            return corners
        return moved_inside(self.lab, (2 * x[0] - good[0], 2 * x[1] - good[1])), *corners

    def _nearest(self, x: Point) -> Point:
        """The nearest point of least loss."""
        minimisers = self._minimisers
        return minimisers[0] if len(minimisers) == 1 else min(minimisers, key=lambda m: math.dist(x, m))

    def importance(self, truth: Truth) -> float:
        """The reward that can still be gained: the reward of the least loss minus that of the present point."""
        low, high = self.lab.reward_range
        return high - min(max(-truth.y / 100, low), high)

    def plan(self, truth: Truth, n: int) -> tuple[Point, ...]:
        """The nearest point of least loss, again and again."""
        return (self._nearest(truth.x),) * n

    def regret(self, moment: Moment[Truth]) -> float:
        """The greatest reward minus the action's."""
        if moment.before is None:
            return self.idle(moment.after)
        return self.lab.reward_range[1] - moment.reward

    def idle(self, truth: Truth) -> float:
        """Regret of staying at the point."""
        return self.importance(truth)
