"""The oracle of losses in arrays, in the same steps as in `teachers.oracles.optimization`."""

import numpy as np

from teachers.batches import Moments, OracleBatch, Said, Stakes, subset
from teachers.oracles.optimization import BEHIND, CLOSE, ENOUGH, SHARES, SHORT
from teachers.oracles.optimization.claims import FARTHER, between, corners_of
from worlds.batches import Bools, Floats, Ints
from worlds.batches.optimization import Landscapes, OptimizationBatch, Points, State
from worlds.optimization import SCALE, TOLERANCE, Optimization

_TIE = 1e-6
_EXACT = 22  # powers of ten up to this are floats
_POWERS = 10.0 ** np.maximum(np.arange(-_EXACT, _EXACT + 1), 0)  # a table, as numpy takes long for each of them


class _Gains(Stakes):
    """The reward that a proposal can gain."""

    def __init__(self, y: Floats, rewards: tuple[float, float]) -> None:
        low, self._high = rewards
        self.importance = self._high - np.clip(-y / SCALE, low, self._high)

    def regret(self, moments: Moments[State]) -> Floats:
        """The greatest reward minus the reward of the action."""
        return self._high - moments.reward


class OptimizationOracleBatch(OracleBatch[State]):
    """Judges proposals by the change of the loss, and advises points after computing their loss."""

    worlds: OptimizationBatch

    def judge(self, moments: Moments[State]) -> Said:
        """Judge the change of the loss, as a whole and by coordinate; advise a better point; warn of a worse one."""
        _, _, _, after, _, turn, over = moments
        landscapes = self.worlds.landscapes(after)
        verdicts, judges = self._verdicts(moments, landscapes)
        praise, blame = (verdicts > 0).T
        x, y = _points(after.x), after.y
        solved = y - self.worlds.world.minimum <= TOLERANCE
        good, advised = self._steps(x, y, landscapes, np.flatnonzero(~(solved | over)))
        warns, warned = self._warnings(x, y, landscapes, good, advised, turn, ~over)
        acted = turn > 0
        kinds = subset(acted, acted & praise, acted & blame, ~over & (solved | good), warns)
        advice = np.where(good[:, None], np.stack(advised, 1), after.x)
        return Said(kinds, advice, np.stack(warned, 1), verdicts, judges)

    def stakes(self, state: State) -> Stakes:
        """The reward that can still be gained."""
        return _Gains(state.y, self.worlds.world.reward_range)

    def plan_length(self, state: State, n: int) -> Ints:
        """A point of least loss, again and again."""
        return np.full(len(state.y), n)

    def _verdicts(self, moments: Moments[State], landscapes: Landscapes) -> tuple[np.ndarray, np.ndarray]:
        """The numbers of praises and blames, and whether either names the whole proposal, both of shape (rows, 2)."""
        start, before, after = _points(moments.before.x), moments.before.y, moments.after.y
        end = _points(moments.action)
        changed = _differ(before, after) & ~moments.success
        whole = np.stack([moments.success | (changed & (after < before)), changed & (after >= before)], 1)
        number = whole.astype(np.int64)
        for alone in ((end[0], start[1]), (start[0], end[1])):
            loss = landscapes.value(alone)
            judged = _differ(before, loss) & ((alone[0] != start[0]) | (alone[1] != start[1]))
            number += np.stack([judged & (loss < before), judged & (loss >= before)], 1)
        return number, whole

    def _steps(self, x: Points, y: Floats, landscapes: Landscapes, rows: np.ndarray) -> tuple[Bools, Points]:
        """The members of `rows` with a point to advise, and the points."""
        found = np.zeros(len(y), bool)
        advised = x[0].copy(), x[1].copy()
        minimum = self.worlds.world.minimum

        def advise(rows: np.ndarray, point: Points, fits: Bools) -> np.ndarray:
            """Advise the points that fit; return the remaining rows."""
            fitting = rows[fits]
            found[fitting] = True
            for coordinate, values in zip(advised, point, strict=True):
                coordinate[fitting] = values[fits]
            return rows[~fits]

        here, now, there = _at(x, rows), y[rows], landscapes.at(rows)
        step = _newton(there.gradient(here), there.hessian(here))
        point, able = self._short(here, (here[0] + step[0], here[1] + step[1]), there)
        rows = advise(rows, point, able & (there.value(point) - minimum <= ENOUGH * (now - minimum)))
        for share in (*SHARES, None):
            if not len(rows):
                break
            here, now, there = _at(x, rows), y[rows], landscapes.at(rows)
            point, able = self._short(here, between(here, there.nearest(here)[0], share or SHORT), there)
            loss = there.value(point)
            fits = (loss < now) & _differ(loss, now)
            if share is None:  # a ridge has to be crossed, behind which the minimiser lies
                behind = [between(here, point, 1 + i / FARTHER / 4) for i in BEHIND]
                fits = np.any([_contains(self.worlds.world, far) & (there.value(far) < now) for far in behind], axis=0)
            rows = advise(rows, point, able & fits)
        return found, advised

    def _short(self, x: Points, point: Points, landscapes: Landscapes) -> tuple[Points, Bools]:
        """The points in the domain, at least a tenth of the way away from a minimiser; the rows that have one."""
        world = self.worlds.world
        point = moved_inside(world, point)
        minimiser, distance = landscapes.nearest(point)
        near = np.flatnonzero(distance < (1 - SHORT) * np.hypot(x[0] - minimiser[0], x[1] - minimiser[1]))
        if len(near):
            back = moved_inside(world, between(_at(x, near), _at(minimiser, near), SHORT))
            for coordinate, values in zip(point, back, strict=True):
                coordinate[near] = values
            _, distance = landscapes.nearest(point)
        return point, (distance > CLOSE) & ((point[0] != x[0]) | (point[1] != x[1]))

    def _warnings(
        self, x: Points, y: Floats, landscapes: Landscapes, good: Bools, advised: Points, turn: np.ndarray, may: Bools
    ) -> tuple[Bools, Points]:
        """The rows with a point to warn of, and the points: opposite to the advised one, or a corner."""
        world = self.worlds.world
        corners = np.array(corners_of(world))
        warned = x[0].copy(), x[1].copy()
        found = np.zeros(len(y), bool)
        opposite = moved_inside(world, (2 * x[0] - advised[0], 2 * x[1] - advised[1]))
        for i in range(-1, len(corners)):
            left = np.flatnonzero(may & ~found & (good if i < 0 else True))
            if not len(left):
                continue
            corner = corners[(turn[left] + i) % len(corners)]
            point = _at(opposite, left) if i < 0 else (corner[:, 0], corner[:, 1])
            loss = landscapes.at(left).value(point)
            fits = (loss > y[left]) & _differ(loss, y[left])
            found[left[fits]] = True
            for coordinate, values in zip(warned, point, strict=True):
                coordinate[left[fits]] = values[fits]
        return found, warned


def moved_inside(world: Optimization, point: Points) -> Points:
    """The points with six significant digits, moved into the domain."""
    bounds = zip(map(six_digits, point), world.lows, world.highs, strict=True)
    first, second = (np.minimum(np.maximum(x, low), high) + 0.0 for x, low, high in bounds)
    return first, second


def six_digits(x: Floats) -> Floats:
    """`float(f"{x:.6g}")` of each number."""
    size = np.abs(x)
    digits = 5 - np.floor(np.log10(np.where(size > 0, size, 1.0))).astype(np.int64)
    place = np.minimum(np.maximum(digits, -_EXACT), _EXACT)
    up, down = _POWERS[_EXACT + place], _POWERS[_EXACT - place]
    scaled = x * up / down
    rounded: Floats = np.rint(scaled) / up * down
    # Numbers halfway between two of these, within the rounding of the product, are formatted exactly.
    doubtful = (np.abs(scaled - np.floor(scaled) - 0.5) < _TIE) | (np.abs(digits) > _EXACT)
    for i in np.flatnonzero(doubtful).tolist():
        rounded[i] = float(f"{x[i]:.6g}")
    return rounded


def _newton(gradient: tuple[Floats, Floats], hessian: tuple[Floats, Floats, Floats]) -> Points:
    """Newton's steps, with the curvature raised to be positive in every direction."""
    (g1, g2), (h11, h12, h22) = gradient, hessian
    mean, radius = (h11 + h22) / 2, np.hypot((h11 - h22) / 2, h12)
    floor = 1e-3 * (np.abs(mean) + radius) + 1e-9
    extra = np.maximum(0.0, floor - (mean - radius))
    h11, h22 = h11 + extra, h22 + extra
    determinant = h11 * h22 - h12 * h12
    return (h12 * g2 - h22 * g1) / determinant, (h12 * g1 - h11 * g2) / determinant


def _differ(a: Floats, b: Floats) -> Bools:
    """Whether two losses differ in the six digits that phrases show."""
    apart: Bools = np.abs(a - b) > 1e-5 * np.maximum(np.abs(a), np.abs(b))
    return apart


def _contains(world: Optimization, point: Points) -> Bools:
    (low1, low2), (high1, high2) = world.lows, world.highs
    return (low1 <= point[0]) & (point[0] <= high1) & (low2 <= point[1]) & (point[1] <= high2)


def _points(table: Floats) -> Points:
    return table[:, 0], table[:, 1]


def _at(points: Points, rows: np.ndarray) -> Points:
    return points[0][rows], points[1][rows]
