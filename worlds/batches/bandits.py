"""Bandits in arrays."""

from collections.abc import Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.bandits import Bandit, Truth
from worlds.batches import ALL, Bools, Floats, Ints, Outcome, Rows, WorldBatch, chosen, merged, most
from worlds.batches.streams import Streams


class State(NamedTuple):
    """Truths in arrays of shape (rows, arms)."""

    chances: Floats
    payouts: Floats
    means: Floats
    best: Bools
    """Whether an arm is a best one."""
    order: Ints
    """The arms, those that are not best first, and by number among equals."""


class BanditBatch(WorldBatch[Truth, State]):
    """Arms of each row; they stay the same throughout an episode."""

    world: Bandit
    states: ClassVar[int | None] = 1

    def __init__(self, world: Bandit, rows: int) -> None:
        if world.law:
            raise ValueError("arms with looks, as with town=..., have no arrays; set vectorization_mode='sync'")
        super().__init__(world, rows)
        nothing = np.zeros((rows, world.arms))
        self.state = _state(nothing, nothing)

    def load(self, rows: Ints, truths: Sequence[Truth]) -> None:
        """Set the arms."""
        chances = np.array([truth.chances for truth in truths])
        payouts = np.array([truth.payouts for truth in truths])
        self.state = merged(self.state, rows, _state(chances, payouts))

    def draw(self, rows: Ints, rng: np.random.Generator) -> None:
        """Draw the arms of all these rows at once."""
        arms = self.world.problem.draw(rng, (len(rows), self.world.arms))
        self.state = merged(self.state, rows, _state(*arms))

    def truth(self, state: State, row: int) -> Truth:
        """The arms."""
        return self.world.problem.truth(state.chances[row], state.payouts[row])

    def advance(self, actions: npt.NDArray[Any], rows: Rows, draws: Streams) -> Outcome:
        """Pull an arm: one uniform draw and, where payouts spread, a normal one."""
        state = self.state
        chances, payouts, best = (chosen(each[rows], actions) for each in (state.chances, state.payouts, state.best))
        pays = draws.random(rows) < chances
        if spread := self.world.problem.spread:
            paid = np.flatnonzero(pays)
            low, high = self.world.reward_range
            drawn = draws.standard_normal(np.arange(self.rows)[rows][paid])
            payouts[paid] = np.clip(payouts[paid] + spread * drawn, low, high)
        return Outcome(np.where(pays, payouts, 0.0), best)

    def observe(self) -> npt.NDArray[np.int64]:
        """Always 0."""
        return np.zeros(self.rows, np.int64)

    def place(self, rows: Rows = ALL) -> Ints:
        """Always 0."""
        return np.zeros(len(self.state.best[rows]), np.int64)

    def seen(self, row: int, place: int) -> int:
        """Always 0."""
        return 0


def _state(chances: Floats, payouts: Floats) -> State:
    means = chances * payouts
    best = means == most(means)[:, None]
    return State(chances, payouts, means, best, best.argsort(axis=1, kind="stable"))
