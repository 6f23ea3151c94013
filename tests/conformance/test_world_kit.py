"""The kit for worlds accepts a good world, and each of its checks rejects a liar that the others let pass."""

import copy
import random
from typing import NamedTuple

import numpy as np
import pytest
from gymnasium import spaces

from worlds import testing as kit
from worlds.actions import is_element
from worlds.world import World, illegal


class Truth(NamedTuple):
    count: int


class Counter(World):
    """Counts up or down, with noise; success is to be above 3."""

    reward_range = (-2.0, 2.0)
    action_syntax = "0 or 1"

    def __init__(self, start=0, *, render_mode=None):
        super().__init__(render_mode=render_mode, start=start)
        self.observation_space = spaces.Dict({"count": spaces.Box(-1000, 1000, (1,), np.int64)})
        self.action_space = spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed, options=options)
        self.count = self.options["start"]
        return self.observe(), {"success": False}

    @property
    def truth(self):
        return Truth(self.count)

    def legal(self, action):
        if not is_element(self.action_space, action):
            raise illegal(action, self.action_syntax)
        return int(action)

    def advance(self, action):
        self.count += 2 * action - 1
        return self.observe(), float(self.np_random.random()), False, False, {"success": self.count > 3}

    def describe(self, observation):
        return f"The count is {observation['count'][0]}."

    def sample_action(self, rng):
        return int(rng.integers(2))

    def observe(self):
        return {"count": np.array([self.count])}

    def _load(self, truth):
        self.count = truth.count


class OutOfSpace(Counter):
    def observe(self):
        return {"count": np.array([self.count, 0])}


class VagueSuccess(Counter):
    def advance(self, action):
        observation, reward, terminated, truncated, _ = super().advance(action)
        return observation, reward, terminated, truncated, {"success": np.bool_(self.count > 3)}


class Taciturn(Counter):
    actions_key = "possible"


class Generous(Counter):
    failure_reward = 3.0


class Unseeded(Counter):
    def reset(self, *, seed=None, options=None):
        result = super().reset(seed=seed, options=options)
        self.np_random.bit_generator.state = np.random.default_rng().bit_generator.state
        return result


class LivingTruth(Counter):
    @property
    def truth(self):
        if not hasattr(self, "cell"):
            self.cell = [self.count]
        return Shared(self.cell)

    def advance(self, action):
        result = super().advance(action)
        self.truth.cell[0] = self.count
        return result

    def reset(self, *, seed=None, options=None):
        result = super().reset(seed=seed, options=options)
        self.truth.cell[0] = self.count
        return result

    def save(self):
        return copy.deepcopy(super().save())

    def _load(self, truth):
        (self.count,) = truth.cell
        self.truth.cell[0] = self.count


class Shared(NamedTuple):
    cell: list


class Forgetful(Counter):
    def restore(self, state):
        super().restore(state[0] if len(state) == 2 else state)


class SelfScratch(Counter):
    def scratch(self):
        return self


class Careless(Counter):
    def legal(self, action):
        if not is_element(self.action_space, action):
            self.count += 1
        return super().legal(action)


class Heedless(Counter):
    def reset(self, *, seed=None, options=None):
        return super().reset(seed=seed)


class Moody(Counter):
    told = 0

    def describe(self, observation):
        self.told += 1
        return f"For the {self.told}th time, the count is {observation['count'][0]}."


class Uncopied(Counter):
    def __deepcopy__(self, memo):
        return type(self)()

    def __reduce__(self):
        return type(self), ()

    def step(self, action):
        if not hasattr(self, "count"):
            self.reset(seed=0)
        return super().step(action)


class GlobalNoise(Counter):
    def advance(self, action):
        random.random()
        return super().advance(action)


class Recycler(Counter):
    def observe(self):
        self.cell = getattr(self, "cell", np.array([0]))
        self.cell[0] = self.count
        return {"count": self.cell}


class Stale(Counter):
    lag = 0

    def step(self, action):
        self.lag = 0
        result = super().step(action)
        self.lag = 1
        return result

    def observe(self):
        return {"count": np.array([self.count - self.lag])}


class Daydreamer(Counter):
    """Draws an option that it does not have."""

    def draw_options(self, rng):
        return self.options | {"end": int(rng.integers(9))}


LIARS = {
    kit.check_spaces: OutOfSpace,
    kit.check_info: VagueSuccess,
    kit.check_listed_actions: Taciturn,
    kit.check_reward_range: Generous,
    kit.check_seeding: Unseeded,
    kit.check_truth: LivingTruth,
    kit.check_save: Forgetful,
    kit.check_lab: SelfScratch,
    kit.check_legal: Careless,
    kit.check_reset_options: Heedless,
    kit.check_describe: Moody,
    kit.check_copies: Uncopied,
    kit.check_global_random: GlobalNoise,
    kit.check_fresh: Recycler,
    kit.check_observe: Stale,
    kit.check_drawn_options: Daydreamer,
}


def test_a_good_world_passes():
    kit.check_world(Counter)


class FromOne(Counter):
    def __init__(self, *, render_mode=None):
        super().__init__(render_mode=render_mode)
        self.action_space = spaces.Discrete(2, start=1)


def test_actions_are_numbered_from_0():
    with pytest.raises(AssertionError, match=r"actions of Discrete\(2, start=1\) are not numbered from 0; number them"):
        kit.check_spaces(FromOne)


def test_every_check_has_a_liar():
    assert set(LIARS) == set(kit.CHECKS)


@pytest.mark.parametrize(("check", "liar"), LIARS.items(), ids=lambda value: value.__name__)
def test_a_liar_is_rejected_by_its_own_check_only(check, liar, rejects):
    assert rejects(kit.CHECKS, liar) == [check.__name__]
