"""Multi-armed bandits: the eight problems of gym-bandits, with the arms in a new order in each episode."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import permutations
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from worlds.actions import is_element
from worlds.towns import town_stream
from worlds.world import World, illegal

__all__ = ["FEATURES", "LAWS", "LEVELS", "PROBLEMS", "Bandit", "Law", "Problem", "Truth", "levels_of"]

_Numbers = npt.NDArray[np.float64]
FEATURES = (("red", "green", "blue"), ("round", "square", "oval"))
"""The looks of arms in a town: words for their colour, and for their shape."""
LEVELS = len(FEATURES[0])
"""Number of levels of payment in a town."""
Law = tuple[tuple[int, ...], ...]
"""The weight of each word of `FEATURES`; the weights of an arm's words add up to its level, 0 to `LEVELS - 1`."""
_NOTHING = (0,) * LEVELS
LAWS: tuple[Law, ...] = tuple(
    tuple(weights if feature == decisive else _NOTHING for feature in range(len(FEATURES)))
    for decisive in range(len(FEATURES))
    for weights in permutations(range(LEVELS))
)
"""The laws that a town may have, each with the same probability: one feature decides, in any order of its words."""


class Truth(NamedTuple):
    """The arms of an episode, in the order of their numbers."""

    chances: tuple[float, ...]
    """Probability that an arm pays at all, 0 to 1."""
    payouts: tuple[float, ...]
    """Mean of what an arm pays when it pays."""
    spread: float
    """Standard deviation of what an arm pays when it pays."""
    means: tuple[float, ...]
    """Expected reward of each arm."""
    looks: tuple[tuple[int, ...], ...] = ()
    """In a town the looks of each arm, as indices of the words of each of `FEATURES`; else empty."""
    law: Law = ()
    """The law of the town, one of `LAWS`; empty without a town."""

    @property
    def best(self) -> tuple[int, ...]:
        """The arms of greatest expected reward; tied arms are all best."""
        greatest = max(self.means)
        return tuple(arm for arm, mean in enumerate(self.means) if mean == greatest)


@dataclass(frozen=True)
class Problem:
    """How the arms of an episode are drawn."""

    draw: Callable[[np.random.Generator, tuple[int, ...]], tuple[_Numbers, _Numbers]]
    """Returns chances and payouts as in `Truth`, given their shape, whose last dimension is the arms."""
    arms: int = 10
    spread: float = 0.0
    """Standard deviation of what an arm pays when it pays, at least 0."""
    fixed: bool = False
    """Whether the arms and their number are given, and only their order is drawn."""

    def truth(
        self, chances: _Numbers, payouts: _Numbers, looks: tuple[tuple[int, ...], ...] = (), law: Law = ()
    ) -> Truth:
        """The arms of an episode."""
        means = tuple((chances * payouts).tolist())
        return Truth(tuple(chances.tolist()), tuple(payouts.tolist()), self.spread, means, looks, law)

    def levelled(
        self, chances: _Numbers, payouts: _Numbers, levels: npt.NDArray[np.int64]
    ) -> tuple[_Numbers, _Numbers]:
        """Move drawn chances and payouts into the level of each arm; each level has an equal share of the distribution.

        So each arm pays more on average than the arms of lower levels, and over all levels the distribution is
        unchanged.
        """
        if self.spread:
            normal = NormalDist()
            shares = (levels + [normal.cdf(payout) for payout in payouts.tolist()]) / LEVELS
            return chances, np.array([normal.inv_cdf(share) for share in shares.tolist()])
        chances, payouts = (each if (each == 1).all() else (levels + each) / LEVELS for each in (chances, payouts))
        return chances, payouts


def _fixed(*chances: float) -> Problem:
    return Problem(
        lambda rng, n: (rng.permuted(np.broadcast_to(chances, n), axis=-1), np.ones(n)), len(chances), fixed=True
    )


PROBLEMS: dict[str, Problem] = {
    "TenArmedGaussian": Problem(lambda rng, n: (np.ones(n), rng.standard_normal(n)), spread=1.0),
    "TenArmedRandomFixed": Problem(lambda rng, n: (rng.random(n), np.ones(n))),
    "TenArmedRandomRandom": Problem(lambda rng, n: (rng.random(n), rng.random(n))),
    "TenArmedUniformDistributedReward": Problem(lambda rng, n: (np.ones(n), rng.random(n))),
    "TwoArmedDeterministicFixed": _fixed(1.0, 0.0),
    "TwoArmedHighHighFixed": _fixed(0.8, 0.9),
    "TwoArmedHighLowFixed": _fixed(0.8, 0.2),
    "TwoArmedLowLowFixed": _fixed(0.1, 0.2),
}
"""The problems by name; arms that are drawn independently need no shuffling."""
_FREE = ", ".join(name for name, problem in PROBLEMS.items() if not problem.fixed)
_MOST = 10_000


class Bandit(World[Truth, Any, int]):
    """Arms with random payouts, in repeated turns without a state.

    Observation: Discrete(1), always 0; in a town MultiDiscrete, the looks of each arm, shape (arms, 2): indices of the
    words of each of `FEATURES`. Action: Discrete(number of arms), the arm to pull.
    Reward: what the arm pays. Success: the pulled arm is a best one. Nothing terminates.

    Args:
        problem: a key of `PROBLEMS`.
        arms: number of arms, 2 to 10,000, for a problem that draws each by itself; None: the problem's default.
        town: number of a town, at least 0, for a problem that draws each arm by itself. The looks of a town's arms
            decide how well they pay. None: arms have no looks.

    Raises:
        ValueError: an argument is not allowed.
    """

    reward_range = (-100.0, 100.0)
    action_fillers = ("arm", "pull")
    answer_names = ("arm",)
    _truth: Truth

    def __init__(
        self,
        problem: str = "TenArmedRandomFixed",
        *,
        arms: int | None = None,
        town: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode=render_mode, problem=problem, arms=arms, town=town)
        if problem not in PROBLEMS:
            raise ValueError(f"problem {problem!r} is unknown; allowed: {', '.join(PROBLEMS)}")
        if arms is not None and (type(arms) is not int or not 2 <= arms <= _MOST):
            raise ValueError(f"arms must be an integer from 2 to {_MOST:,}, got {arms!r}")
        self.arms = self.problem.arms if arms is None else arms
        if self.arms != self.problem.arms and self.problem.fixed:
            raise ValueError(
                f"problem {problem!r} has {self.problem.arms} arms, got arms={arms}; {_FREE} take any number"
            )
        rng = town_stream("bandits", town)
        if rng and self.problem.fixed:
            raise ValueError(f"problem {problem!r} has no towns, as its arms are given; allowed: {_FREE}")
        self.law: Law = LAWS[rng.integers(len(LAWS))] if rng else ()
        """How well arms pay by their looks; empty without a town."""
        self.observation_space = spaces.Discrete(1) if rng is None else spaces.MultiDiscrete(_looks(self.arms))
        self.action_space = spaces.Discrete(self.arms)
        self.action_syntax = f"the number of an arm, 0 to {self.arms - 1}"

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Draw the arms."""
        super().reset(seed=seed, options=options)
        arms = self.problem.draw(self.np_random, (self.arms,))
        looks: tuple[tuple[int, ...], ...] = ()
        if self.law:
            looks = tuple(map(tuple, self.np_random.integers(_looks(self.arms)).tolist()))
            arms = self.problem.levelled(*arms, levels_of(looks, self.law))
        self._load(self.problem.truth(*arms, looks, self.law))
        return self.observe(), {"success": False}

    @property
    def problem(self) -> Problem:
        """How the arms are drawn."""
        return PROBLEMS[self.options["problem"]]

    @property
    def truth(self) -> Truth:
        """The arms."""
        return self._truth

    @property
    def failure_reward(self) -> float:
        """The expected reward of the worst arm, at most 0."""
        return min(0.0, *self._truth.means) if hasattr(self, "_truth") else 0.0

    def legal(self, action: Any) -> int:
        """The arm as a Python integer."""
        # Without this short cut past Gymnasium's own check a turn takes a quarter longer.
        if not (type(action) is int and 0 <= action < self.arms) and not is_element(self.action_space, action):
            raise illegal(action, self.action_syntax)
        return int(action)

    def advance(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """See `pull`."""
        reward, success = self.pull(action)
        return self.observe() if self.law else 0, reward, False, False, {"success": success}

    def pull(self, action: int) -> tuple[float, bool]:
        """The reward of an arm, and whether it is best: one uniform draw and, where payouts spread, a normal one."""
        chances, payouts, spread, _, _, _ = self._truth
        reward = 0.0
        if self.np_random.random() < chances[action]:
            reward = payouts[action]
            if spread:
                low, high = self.reward_range
                reward = min(max(reward + spread * float(self.np_random.standard_normal()), low), high)
        return reward, action in self._best

    def observe(self) -> Any:
        """Always 0; in a town the looks of each arm."""
        return np.array(self._truth.looks) if self.law else 0

    def describe(self, observation: Any) -> str:
        """The empty string, since a bandit has no state; in a town the looks of each arm in words."""
        if not self.law:
            return ""
        looks = (
            " ".join(words[i] for words, i in zip(FEATURES, row, strict=True))
            for row in np.asarray(observation).tolist()
        )
        return "Arms: " + ", ".join(f"{arm} {words}" for arm, words in enumerate(looks))

    def sample_action(self, rng: np.random.Generator) -> int:
        """A uniform arm."""
        return int(rng.integers(self.arms))

    def _load(self, truth: Truth) -> None:
        if truth is not getattr(self, "_truth", None):  # a claim may restore one for each arm
            self._truth = truth
            self._best = frozenset(truth.best)


def _looks(arms: int) -> npt.NDArray[np.int64]:
    """Number of words for each feature of each arm, shape (arms, features)."""
    return np.tile([len(words) for words in FEATURES], (arms, 1))


def levels_of(looks: Sequence[Sequence[int]], law: Law) -> npt.NDArray[np.int64]:
    """The level of each of some arms, shape (arms,)."""
    return np.array([sum(weights[i] for weights, i in zip(law, row, strict=True)) for row in looks])
