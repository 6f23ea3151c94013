"""The expert tier's knowledge of an environment: the expert's actions, and roll-outs."""

import copy
from collections.abc import Callable, Iterator
from functools import partial
from math import isfinite
from statistics import median
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from teachers.planning.expert.asking import ExpertError, Policy, ReplayError, Same, Watched
from worlds.wrapped.generators import draws, reseed
from worlds.wrapped.gym_world import GymWorld, Position
from worlds.wrapped.position import Episode, plain_parts, same, still

_Env = gymnasium.Env[Any, Any]
_DIGITS = 3  # of amounts
_ALIKE = 4  # times: what roll-outs with other draws differ by at most, to be one amount
_KEPT = 6  # positions
_ASKED = 8  # times in each state


class Lead(NamedTuple):
    """How much more one action earns than another."""

    more: float
    """To three digits, in units of reward."""
    rollouts: int
    """Number of compared pairs of roll-outs; 1 if they drew nothing."""


class Guide:
    """An expert, asked and followed in environments of its own.

    A roll-out begins in a given state with draws of its own, takes an action and then follows the expert; it earns the
    sum of rewards. Comparing two actions takes `rollouts` pairs of roll-outs, each pair with equal draws; one pair
    suffices if the environment seems deterministic and neither roll-out draws random numbers.

    Args:
        make: makes the expert of an environment after its reset.
        rollouts: number of pairs.
        certain: whether the environment seems deterministic.
        horizon: most actions of a roll-out.
        tolerance: largest difference between numbers of actions that counts as equal.
        margin: smallest difference of earnings that counts.
        others: number of actions to compare with the expert's, in search of a worse one.
    """

    def __init__(
        self,
        make: Callable[[_Env], Policy],
        *,
        rollouts: int,
        certain: bool,
        horizon: int,
        tolerance: float,
        margin: float,
        others: int,
    ) -> None:
        self._make, self.rollouts, self.horizon = make, rollouts, horizon
        self._least = 1 if certain else rollouts
        self.tolerance, self._margin, self.others = tolerance, margin, others
        self.ended = ""
        """Why it is silent from now on; empty: it is not."""
        self._env: _Env | None = None
        self._scenes: dict[tuple[Episode, int], Watched] = {}
        self._earned: dict[tuple[Episode, int, bool], dict[tuple[Any, int], tuple[float, bool]]] = {}

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_env": None, "_scenes": {}, "_earned": {}}

    def action(self, truth: Position, lab: GymWorld, anew: bool = False) -> Any:
        """The expert's exact action; `said` rounds it.

        Args:
            truth: the state.
            lab: a world like the taught one.
            anew: whether to ask a new expert that has watched a replay of the episode, for checks.

        Raises:
            ExpertError: it gives no answer, or different answers when asked eight times (twice, if it belongs to the
                environment).
        """
        fresh = self._source(truth, lab, anew)
        scene = fresh()
        first = scene.ask()
        for _ in range(_ASKED - 1 if isinstance(self._make, Same) else 1):
            scene = scene if isinstance(self._make, Same) else fresh()
            if not self.alike(first, again := scene.ask()):
                raise ExpertError(
                    f"the expert changes its mind: asked twice in one state it gave {first!r} and {again!r}; make it "
                    "deterministic, such as by the most probable action"
                )
        return first

    def said(self, action: Any, lab: GymWorld) -> Any:
        """An action with numbers rounded within the tolerance."""
        try:
            return lab.legal(_rounded(action, max(0, int(np.ceil(-np.log10(self.tolerance))))))
        except ValueError:  # rounded out of bounds
            return action

    def alike(self, one: Any, other: Any) -> bool:
        """Whether two actions are equal to within the tolerance."""
        if isinstance(one, float) and isinstance(other, float):
            return abs(one - other) <= self.tolerance
        if isinstance(one, tuple) and isinstance(other, tuple):
            return len(one) == len(other) and all(map(self.alike, one, other))
        return bool(one == other)

    def candidates(self, truth: Position, lab: GymWorld, action: Any, count: int) -> list[Any]:
        """At most `count` other actions, drawn for each state."""
        rng = np.random.default_rng([truth.seed, truth.turn, 2])
        space = lab.action_space
        if isinstance(space, gymnasium.spaces.Discrete):
            drawn = [int(space.start + each) for each in rng.permutation(int(space.n))]
        else:
            drawn = [self.said(lab.legal(lab.sample_action(rng)), lab) for _ in range(2 * count)]
        return [each for each in drawn if not self.alike(each, action)][:count]

    def check(self, truth: Position, lab: GymWorld) -> None:
        """Check that roll-outs can begin in a state.

        Raises:
            ExpertError: they cannot.
        """
        self._source(truth, lab, anew=False)()

    def measure(self, truth: Position, lab: GymWorld, one: Any, other: Any) -> Lead | None:
        """How much more one action earns than another: the median over all pairs of roll-outs.

        None unless all pairs agree on the sign, and on the amount within a factor of four.

        Raises:
            ExpertError: the expert cannot be followed.
        """
        found: list[float] = []
        for each in self._differences(truth, lab, one, other, anew=False):
            found.append(each)
            sizes = [abs(each) for each in found]
            if not all(map(isfinite, sizes)):  # rewards that are no numbers
                return None
            if min(sizes) < self._margin or max(sizes) > _ALIKE * min(sizes) or min(found) < 0 < max(found):
                return None
        return Lead(float(f"{median(found):.{_DIGITS}g}"), len(found))

    def confirms(self, lead: Lead, truth: Position, lab: GymWorld, one: Any, other: Any) -> bool:
        """Whether the same number of roll-outs with other draws confirms how much more one action earns than another.

        Their median must have the sign of the amount, and its size within a factor of four; without random draws it
        must equal the amount.
        """
        try:
            differences = list(self._differences(truth, lab, one, other, anew=True))
        except ExpertError:
            return False
        amount, found = lead.more, median(differences)
        if len(differences) != lead.rollouts:
            return False
        if lead.rollouts == 1:
            return amount != 0 and abs(found - amount) <= 0.51 * 10 ** (1 - _DIGITS) * abs(amount)
        return amount * found > 0 and abs(amount) / _ALIKE <= abs(found) <= _ALIKE * abs(amount)

    def demonstrate(self, truth: Position, lab: GymWorld, n: int, anew: bool = False) -> tuple[Any, ...]:
        """At most `n` actions of the expert from a state on, until the episode is over; `anew` is as in `action`.

        If roll-outs draw random numbers: the common beginning of `rollouts` of them, with different draws.

        Raises:
            ExpertError: it gives no answer.
        """
        fresh, common = self._source(truth, lab, anew), n
        for number in range(self.rollouts):
            scene, over = fresh(), False
            reseed(scene.env, truth.seed, truth.turn, int(anew), number)
            before = draws(scene.env)
            actions: list[Any] = []
            while not over and len(actions) < common:
                actions.append(scene.ask())
                _, over = scene.step(actions[-1])
            if not number:
                first = actions
            pairs = zip(actions, first, strict=False)
            common = next((i for i, (one, other) in enumerate(pairs) if one != other), len(actions))
            if draws(scene.env) == before:
                break
        return tuple(first[:common])

    def _differences(self, truth: Position, lab: GymWorld, one: Any, other: Any, anew: bool) -> Iterator[float]:
        """The earnings of one action minus those of another, pair by pair."""
        known = _remembered(self._earned, (truth.episode, truth.turn, anew), dict)
        fresh: Callable[[], Watched] | None = None
        for number in range(self.rollouts):
            for action in (one, other):
                if (action, number) not in known:
                    fresh = fresh or self._source(truth, lab, anew)
                    seed = truth.seed, truth.turn, int(anew), number
                    known[action, number] = self._earn(fresh(), action, seed)
            (mine, drew), (its, also) = known[one, number], known[other, number]
            yield mine - its
            if number + 1 >= self._least and not drew and not also:
                return

    def _earn(self, scene: Watched, action: Any, seed: tuple[int, ...]) -> tuple[float, bool]:
        """The earnings of a roll-out, and whether it drew random numbers."""
        reseed(scene.env, *seed)
        before = draws(scene.env)
        earned, over = scene.step(action)
        for _ in range(self.horizon - 1):
            if over:
                break
            reward, over = scene.step(scene.ask())
            earned += reward
        return earned, draws(scene.env) != before

    def _source(self, truth: Position, lab: GymWorld, anew: bool) -> Callable[[], Watched]:
        """Makes scenes of a state, one in use at a time: copies, or replays if copies are not faithful."""
        if truth.episode.anchor is None:
            return partial(self._replayed, truth, lab)
        if anew:
            return self._replayed(truth, lab).copy
        here: Watched = _remembered(self._scenes, (truth.episode, truth.turn), partial(self._arrived, truth, lab))
        return here.copy

    def _arrived(self, truth: Position, lab: GymWorld) -> Watched:
        """The scene of a state, made from the scene one action earlier if that is cached."""
        before = self._scenes.get((truth.episode, truth.turn - 1))
        if before is None:
            return self._replayed(truth, lab)
        scene = before.copy()
        if not same(scene.step(truth.episode.actions[truth.turn - 1])[0], truth.episode.rewards[truth.turn - 1]):
            raise ReplayError("the episode cannot be replayed: an action earned something else")
        return self._checked(scene, truth, lab)

    def _replayed(self, truth: Position, lab: GymWorld) -> Watched:
        """The scene of a state, by a replay of the episode's actions.

        Raises:
            ExpertError: the replay leads to another state.
        """
        episode = truth.episode
        if episode.anchor is None:
            if self._env is None:
                self._env = lab.scratch().env
            env = self._env
            observation, info = env.reset(seed=episode.seed, options=copy.deepcopy(episode.options))
            if not same(still(observation), episode.observation):
                raise ReplayError("the episode cannot be replayed: reset gave another observation")
            _check_parts(env, episode.parts)
        else:
            env, info = copy.deepcopy((episode.anchor, episode.info))
            observation = episode.observation
        scene = Watched.begin(env, self._make, observation, info)
        for action, paid in zip(truth.actions, episode.rewards, strict=False):
            if not same(scene.step(action)[0], paid):
                raise ReplayError("the episode cannot be replayed: an action earned something else")
        return self._checked(scene, truth, lab)

    def _checked(self, scene: Watched, truth: Position, lab: GymWorld) -> Watched:
        """The scene, if its observation is the episode's, and for the present state its hidden parts, too.

        Raises:
            ExpertError: they differ.
        """
        episode = truth.episode
        if episode.live is not None and truth.turn == len(episode.actions):
            _check_parts(scene.env, plain_parts(episode.live))
        if not same(still(scene.observation), lab.state_of(truth)):
            raise ReplayError("the episode cannot be replayed: its actions led to another observation")
        return scene


def _check_parts(env: _Env, wanted: dict[str, Any]) -> None:
    """Compare the parts of an environment's state.

    Raises:
        ExpertError: they differ.
    """
    parts = plain_parts(env)
    differ = [name for name, part in wanted.items() if name not in parts or not same(part, parts[name])]
    if differ:
        raise ExpertError(f"the episode cannot be replayed: that gave another value of {', '.join(differ)}")


def _remembered(kept: dict[Any, Any], key: Any, make: Callable[[], Any]) -> Any:
    """The cached value of a key, made if missing; the oldest entries are dropped."""
    if key not in kept:
        made = make()
        while len(kept) >= _KEPT:
            del kept[next(iter(kept))]
        kept[key] = made
    return kept[key]


def _rounded(action: Any, digits: int) -> Any:
    if isinstance(action, tuple):
        return tuple(_rounded(each, digits) for each in action)
    return round(action, digits) if isinstance(action, float) else action
