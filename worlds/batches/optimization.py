"""Optimization in arrays: the last proposal of each row, its loss, and the shift of the loss."""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.batches import ALL, Bools, Floats, Ints, Outcome, Rows, WorldBatch, merged, without
from worlds.batches.streams import Streams
from worlds.optimization import SCALE, TOLERANCE, Landscape, Loss, Optimization, Truth

Points = tuple[Floats, Floats]
"""Both coordinates of many points."""


class State(NamedTuple):
    """Truths in arrays."""

    x: Floats
    """Of shape (rows, 2)."""
    y: Floats
    shift: Floats
    """Of shape (rows, 2)."""


class Landscapes:
    """A loss with a shift per row: `worlds.optimization.Landscape` in arrays.

    Args:
        loss: one of `LOSSES`, whose functions take arrays.
        shift: both coordinates of the shifts; None: no row is shifted.
    """

    def __init__(self, loss: Loss, shift: Points | None) -> None:
        self.loss, self.shift = loss, shift

    def at(self, rows: Rows) -> "Landscapes":
        """The losses of some rows."""
        return self if self.shift is None else Landscapes(self.loss, (self.shift[0][rows], self.shift[1][rows]))

    def value(self, x: Points) -> Floats:
        """The loss."""
        value: Any = self.loss.value
        loss: Floats = value(*x) if self.shift is None else value(self._place(0, x)[0], self._place(1, x)[0])
        return loss

    def gradient(self, x: Points) -> tuple[Any, Any]:
        """The two first derivatives."""
        gradient: Any = self.loss.gradient
        if self.shift is None:
            g1, g2 = gradient(*x)
            return g1, g2
        (z1, sign1), (z2, sign2) = self._place(0, x), self._place(1, x)
        g1, g2 = gradient(z1, z2)
        return sign1 * g1, sign2 * g2

    def hessian(self, x: Points) -> tuple[Any, Any, Any]:
        """The second derivatives: by x1 twice, by both, by x2 twice."""
        hessian: Any = self.loss.hessian
        if self.shift is None:
            h11, h12, h22 = hessian(*x)
            return h11, h12, h22
        (z1, sign1), (z2, sign2) = self._place(0, x), self._place(1, x)
        h11, h12, h22 = hessian(z1, z2)
        return h11, sign1 * sign2 * h12, h22

    def nearest(self, x: Points) -> tuple[Points, Floats]:
        """For each point, the nearest point of least loss, mirror images included, and its distance."""
        best, least = None, np.full(len(x[0]), np.inf)
        for minimiser in self.loss.minimisers:
            for m1, m2 in product(self._images(0, minimiser[0]), self._images(1, minimiser[1])):
                distance = np.hypot(x[0] - m1, x[1] - m2)
                nearer = distance < least  # false for images outside the domain, whose distance is NaN
                least = np.where(nearer, distance, least)
                best = (m1, m2) if best is None else (np.where(nearer, m1, best[0]), np.where(nearer, m2, best[1]))
        first, second = best or x
        return (np.broadcast_to(first, least.shape), np.broadcast_to(second, least.shape)), least

    def _place(self, i: int, x: Points) -> Points:
        """The unshifted coordinates, and -1 where they were reflected, else 1."""
        shift = (self.shift or x)[i]
        z, low, high = x[i] - shift, self.loss.lows[i], self.loss.highs[i]
        inside = np.where(z < low, 2 * low - z, np.where(z > high, 2 * high - z, z))
        return inside, np.where(inside == z, 1.0, -1.0)

    def _images(self, i: int, m: float) -> list[Any]:
        """Shifted coordinates of a minimiser, mirror images included; NaN outside the domain."""
        if self.shift is None:
            return [m]
        shift, low, high = self.shift[i], self.loss.lows[i], self.loss.highs[i]
        images = [m + shift, 2 * low - m + shift, 2 * high - m + shift]
        return [np.where((low <= image) & (image <= high), image, np.nan) for image in images]


class OptimizationBatch(WorldBatch[Truth, State]):
    """Proposals for a loss of `LOSSES`."""

    world: Optimization

    def __init__(self, world: Optimization, rows: int) -> None:
        super().__init__(world, rows)
        if callable(world.options["loss"]):
            raise ValueError("loss in arrays must be a named one, got a function; use mode 'sync' for functions")
        self.state = State(np.zeros((rows, 2)), np.zeros(rows), np.zeros((rows, 2)))

    def landscapes(self, state: State) -> Landscapes:
        """The shifted losses."""
        shift = (state.shift[:, 0], state.shift[:, 1]) if self.world.options["shift"] else None
        return Landscapes(self.world.loss, shift)

    def load(self, rows: Ints, truths: Sequence[Truth]) -> None:
        """Set the proposals."""
        parts = (np.array([truth[i] for truth in truths]) for i in range(3))
        self.state = merged(self.state, rows, State(*parts))
        self._begin(rows)

    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Draw first points, and shifts if the option `shift` is set."""
        world, shape = self.world, (len(rows), 2)
        x = rng.uniform(world.lows, world.highs, shape)
        low, high = np.transpose(world.shift_bounds())
        shift = rng.uniform(low, high, shape) if world.options["shift"] else np.zeros(shape)
        fresh = State(x, np.zeros(len(rows)), shift)
        self.state = merged(self.state, rows, fresh._replace(y=self.landscapes(fresh).value((x[:, 0], x[:, 1]))))
        self._begin(rows)

    def truth(self, state: State, row: int) -> Truth:
        """The proposal, its loss as the scalar world has it to the last bit, and the shift."""
        (x1, x2), (shift1, shift2) = state.x[row].tolist(), state.shift[row].tolist()
        shift = shift1, shift2
        return Truth((x1, x2), Landscape(self.world.loss, shift).value(x1, x2), shift)

    def number_states(self, most: int) -> int:
        """Give each new proposal of a row the lowest free number."""
        bound = 2 * most  # so that few need more
        self._known, self._most = np.full((self.rows, bound, 2), np.nan), most
        return bound

    def _begin(self, rows: Ints) -> None:
        if hasattr(self, "_known"):
            self._known[rows] = np.nan

    def forget(self, rows: Ints, lost: Bools) -> int:
        """Free numbers; the bound grows if proposals that may come again need it."""
        kept = int(np.count_nonzero(~lost, axis=1).max())
        bound: int = max(lost.shape[1], kept + self._most)
        self._known = without(self._known, rows, lost, bound, np.nan)
        return bound

    def place(self, rows: Rows = ALL) -> Ints:
        """The numbers of the proposals."""
        x1, x2 = self.state.x[rows].T
        place = np.full(len(x1), -1)
        for number in range(self._known.shape[1]):  # one by one, as all at once take much memory
            known = self._known[rows, number]
            place[(known[:, 0] == x1) & (known[:, 1] == x2)] = number
        new = np.flatnonzero(place < 0)
        those = np.arange(self.rows)[rows][new]
        place[new] = np.isnan(self._known[those, :, 0]).argmax(1)
        self._known[those, place[new]] = self.state.x[those]
        return place

    def seen(self, row: int, place: int) -> dict[str, Floats]:
        """The proposal with this number and its loss, as the scalar world shows them."""
        x1, x2 = self._known[row, place].tolist()
        shift1, shift2 = self.state.shift[row].tolist()
        y = Landscape(self.world.loss, (shift1, shift2)).value(x1, x2)
        return {"x": np.array((x1, x2)), "y": np.array((y,))}

    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Evaluate the loss."""
        world = self.world
        y = self.landscapes(self.state).at(rows).value((actions[:, 0], actions[:, 1]))
        self.state = merged(self.state, rows, State(actions, y, self.state.shift[rows]))
        reward = -np.minimum(np.maximum(y, world.minimum), world.corner) / SCALE
        return Outcome(reward, y - world.minimum <= TOLERANCE)

    def observe(self) -> dict[str, Floats]:
        """The last proposals and their losses."""
        return {"x": self.state.x.copy(), "y": self.state.y[:, None].copy()}
