"""Posterior of bandits: exact, by conjugate distributions of each arm, over orders of given arms, and over laws."""

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import betainc, betaincinv, ndtr, ndtri

from worlds.bandits import LAWS, LEVELS, Bandit, Truth, levels_of
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
    """Normal payouts around standard normal means; cutting rewards at 100 changes no digit."""
    precision = 1 + seen.pulls
    return np.ones(shape), rng.normal(seen.total / precision, precision**-0.5, shape)


_FREE: dict[str, _Draw] = {
    "TenArmedGaussian": _gaussian,
    "TenArmedRandomFixed": lambda rng, seen, shape: (_chances(rng, seen, shape), np.ones(shape)),
    "TenArmedRandomRandom": lambda rng, seen, shape: (_chances(rng, seen, shape), _payouts(rng, seen, shape)),
    "TenArmedUniformDistributedReward": lambda rng, seen, shape: (np.ones(shape), _payouts(rng, seen, shape)),
}
"""Draws chances and payouts, shape (worlds, arms), for problems with independent arms."""


class Known(NamedTuple):
    """What the student knows of the chances or payouts of arms, apart from their levels."""

    cdf: Callable[[_Numbers], _Numbers]
    """The probability that an arm's number is below a quantile, 0 to 1, of its prior; shapes (..., arms)."""
    ppf: Callable[[_Numbers], _Numbers]
    """The quantile function: the arm's number for a probability."""


def _known_chances(seen: Seen) -> Known:
    rest = seen.pulls - seen.paid
    return Known(lambda x: betainc(1 + seen.paid, 1 + rest, x), lambda p: betaincinv(1 + seen.paid, 1 + rest, p))


def _known_payouts(seen: Seen) -> Known:
    paid = seen.paid > 0
    return Known(lambda x: np.where(paid, seen.last < x, x), lambda p: np.where(paid, seen.last, p))


def _known_gaussian(seen: Seen) -> Known:
    precision = 1 + seen.pulls
    mean, scale = seen.total / precision, precision**-0.5
    return Known(lambda x: ndtr((ndtri(x) - mean) / scale), lambda p: mean + scale * ndtri(p))


def _known_ones(seen: Seen) -> Known:
    """A number that is always 1, at each level."""
    return Known(lambda x: x, np.ones_like)


_LEVELLED: dict[str, tuple[Callable[[Seen], Known], Callable[[Seen], Known]]] = {
    "TenArmedGaussian": (_known_ones, _known_gaussian),
    "TenArmedRandomFixed": (_known_chances, _known_ones),
    "TenArmedRandomRandom": (_known_chances, _known_payouts),
    "TenArmedUniformDistributedReward": (_known_ones, _known_payouts),
}
"""Functions for the chances and the payouts of problems whose arms can have levels."""


class BanditPosterior(Posterior[Truth, Bandit]):
    """The arms, given the rewards that the teacher said; other pulls are no evidence."""

    chancy = True

    def outcome(self, action: int) -> tuple[float, bool]:
        """What a pull pays. The looks of a town's arms, which `advance` would show, stay the same."""
        return self.lab.pull(action)

    def openings(self, turns: Sequence[WorldTurn[Truth]], rng: np.random.Generator) -> Iterator[Truth]:
        """Draw the arms."""
        seen, problem = self._seen(turns), self.lab.problem
        if turns[0].truth.law:
            yield from self._lawful(turns[0].truth.looks, seen, rng)
        draw = _ordered(turns[0].truth, seen) if problem.fixed else _FREE[self.lab.options["problem"]]
        while True:
            for chances, payouts in zip(*draw(rng, seen, (_BLOCK, self.lab.arms)), strict=True):
                yield problem.truth(chances, payouts)

    def _lawful(self, looks: Sequence[tuple[int, ...]], seen: Seen, rng: np.random.Generator) -> Iterator[Truth]:
        """Draw the hidden law of the town, then the arms.

        A law's probability is proportional to that of all arms being in the levels that it gives them.
        """
        problem, shape = self.lab.problem, (_BLOCK, self.lab.arms)
        levels = np.array([levels_of(looks, law) for law in LAWS])
        parts = [known(seen) for known in _LEVELLED[self.lab.options["problem"]]]
        lows, highs = (np.array([part.cdf(level / LEVELS) for part in parts]) for level in (levels, levels + 1))
        shares = highs - lows  # by part, law and arm
        odds = np.prod(shares, axis=(0, 2))
        if not odds.sum() > 0:
            raise NoWorldError("no law of a town pays these rewards")
        while True:
            laws = rng.choice(len(LAWS), _BLOCK, p=odds / odds.sum())
            drawn = [
                part.ppf(low[laws] + rng.random(shape) * share[laws])
                for part, low, share in zip(parts, lows, shares, strict=True)
            ]
            for law, chances, payouts in zip(laws.tolist(), *drawn, strict=True):
                yield problem.truth(chances, payouts, tuple(looks), LAWS[law])

    def quantities(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        """Means of arms, and how well they agree with the rewards, known and unknown."""
        means = turns[0].truth.means
        rewards = [(turn.reward, means[turn.action], turn.reward_known) for turn in turns if turn.action is not None]
        return {
            "mean of arm 0": means[0],
            "greatest mean": max(means),
            "fit to known rewards": math.fsum((reward - 0.5) * mean for reward, mean, known in rewards if known),
            "unknown rewards": math.fsum(reward for reward, _, known in rewards if not known),
            **self._quantities_of_law(turns),
        }

    def _quantities_of_law(self, turns: Sequence[WorldTurn[Truth]]) -> dict[str, float]:
        truth = turns[0].truth
        if not truth.law:
            return {}
        levels = levels_of(truth.looks, truth.law).tolist()
        rewards = [
            (turn.reward, levels[turn.action]) for turn in turns if turn.action is not None and turn.reward_known
        ]
        return {
            "law": LAWS.index(truth.law),
            "fit of levels": math.fsum((reward - 0.5) * level for reward, level in rewards),
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
