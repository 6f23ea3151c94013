"""Posterior of bandits: exact, by conjugate distributions of each arm, or over the orders of given arms."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from worlds.bandits import Bandit, Truth
from worlds.posteriors import NoWorldError, Posterior
from worlds.world import WorldTurn

__all__ = ["BanditPosterior"]

_Numbers = npt.NDArray[np.float64]
_BLOCK = 64  # worlds that are drawn at once


class Seen(NamedTuple):
    """The known rewards of each arm."""

    pulls: _Numbers
    """Number of known rewards."""
    paid: _Numbers
    """Number of those that are not 0."""
    total: _Numbers
    """Their sum."""
    last: _Numbers
    """The last that is not 0, or 0."""


_Draw = Callable[[np.random.Generator, Seen, tuple[int, int]], tuple[_Numbers, _Numbers]]


def _chances(rng: np.random.Generator, seen: Seen, shape: tuple[int, int]) -> _Numbers:
    """Uniform chances of paying, given how often each arm paid."""
    return rng.beta(1 + seen.paid, 1 + seen.pulls - seen.paid, shape)


def _payouts(rng: np.random.Generator, seen: Seen, shape: tuple[int, int]) -> _Numbers:
    """Uniform payouts, which are known as soon as an arm has paid."""
    return np.where(seen.paid > 0, seen.last, rng.random(shape))


def _gaussian(rng: np.random.Generator, seen: Seen, shape: tuple[int, int]) -> tuple[_Numbers, _Numbers]:
    """Normal payouts around standard normal means; that rewards are cut at 100 changes no digit."""
    precision = 1 + seen.pulls
    return np.ones(shape), rng.normal(seen.total / precision, precision**-0.5, shape)


_FREE: dict[str, _Draw] = {
    "TenArmedGaussian": _gaussian,
    "TenArmedRandomFixed": lambda rng, seen, shape: (_chances(rng, seen, shape), np.ones(shape)),
    "TenArmedRandomRandom": lambda rng, seen, shape: (_chances(rng, seen, shape), _payouts(rng, seen, shape)),
    "TenArmedUniformDistributedReward": lambda rng, seen, shape: (np.ones(shape), _payouts(rng, seen, shape)),
}
"""Draws chances and payouts, shape (worlds, arms), where each arm is drawn by itself."""


class BanditPosterior(Posterior[Truth, Bandit]):
    """The arms, given the rewards that were said; pulls whose rewards were not said say nothing."""

    chancy = True

    def openings(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Iterator[Truth]:
        """Draw the arms."""
        seen, problem = self._seen(turns), self.lab.problem
        draw = _ordered(turns[0].truth, seen) if problem.fixed else _FREE[self.lab.options["problem"]]
        while True:
            for chances, payouts in zip(*draw(rng, seen, (_BLOCK, self.lab.arms)), strict=True):
                yield problem.truth(chances, payouts)

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """Means of arms, and how well they agree with the rewards, known and unknown."""
        means = turns[0].truth.means
        rewards = [(turn.reward, means[turn.action], turn.reward_known) for turn in turns if turn.action is not None]
        return {
            "mean of arm 0": means[0],
            "greatest mean": max(means),
            "fit to known rewards": math.fsum((reward - 0.5) * mean for reward, mean, known in rewards if known),
            "unknown rewards": math.fsum(reward for reward, _, known in rewards if not known),
        }

    def _seen(self, turns: Sequence[WorldTurn[Truth]]) -> Seen:
        seen = Seen(*np.zeros((len(Seen._fields), self.lab.arms)))
        for turn in turns:
            if turn.reward_known and turn.action is not None:
                seen.pulls[turn.action] += 1
                seen.total[turn.action] += turn.reward
                if turn.reward:
                    seen.paid[turn.action] += 1
                    seen.last[turn.action] = turn.reward
        return seen


def _ordered(truth: Truth, seen: Seen) -> _Draw:
    """Draws the order of given arms, each of which pays 1 with its chance, else 0.

    Raises:
        NoWorldError: no order agrees with the rewards.
    """
    orders = np.array(sorted(set(permutations(truth.chances))))
    odds = np.prod(orders**seen.paid * (1 - orders) ** (seen.pulls - seen.paid), axis=1)
    if not (odds.sum() > 0 and np.array_equal(seen.total, seen.paid)):
        raise NoWorldError("no order of the arms pays these rewards")

    def draw(rng: np.random.Generator, seen: Seen, shape: tuple[int, int]) -> tuple[_Numbers, _Numbers]:
        return orders[rng.choice(len(orders), shape[0], p=odds / odds.sum())], np.ones(shape)

    return draw
