"""Environments of one's own that can be copied, played again, or neither."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.ezpickle import EzPickle
from walks import Walk

import llf_teacher
from worlds.wrapped.gym_world import GymWorld, faithful


class Rebuilt(Walk, EzPickle):
    """Copies are new environments, as those of many simulators."""

    def __init__(self):
        EzPickle.__init__(self)


class Twin(Walk):
    """Copies share their state."""

    def __deepcopy__(self, memo):
        return self


class Stubborn(Walk):
    """Cannot be copied."""

    def __deepcopy__(self, memo):
        raise TypeError("no")


class Lucky(Walk):
    """Draws what no seed governs."""

    def step(self, action):
        self.luck = np.random.default_rng()
        return *super().step(action)[:1], float(self.luck.random()), False, False, {}


def test_copies_are_tried_before_they_are_relied_on():
    assert [faithful(cls()) for cls in (Walk, Rebuilt, Twin, Stubborn, Lucky)] == [True] + [False] * 4
    with pytest.raises(ValueError, match=r"copies of <Rebuilt.*allowed: snapshot='replay'"):
        GymWorld(Rebuilt(), snapshot="copy")


@pytest.mark.parametrize("make", [Walk, Rebuilt, lambda: Stubborn])
@pytest.mark.parametrize("length", [5, 40])
def test_labs_go_anywhere_in_an_episode(make, length):
    world = GymWorld(make())
    lab = world.scratch()
    for seed in (3, None):
        world.reset(seed=seed, options={"at": 2})
        truths = [world.truth]
        for i in range(length):
            world.step(i % 2)
            truths.append(world.truth)
        for turn in [0, 1, 3, length - 1, length - 2, length, 0, length]:
            lab.restore(truths[turn])
            assert lab.truth == truths[turn]
            assert lab.env.unwrapped.at == pytest.approx(truths[turn].seen.item(), rel=1e-5)
            if turn < length:
                lab.step(turn % 2)
                assert lab.truth == truths[turn + 1]
                assert lab.truth != truths[turn]
        assert world.truth == truths[-1]
        assert world.truth.actions == tuple(i % 2 for i in range(length))
        assert len({hash(truth) for truth in truths}) == length + 1


def test_a_state_is_what_is_seen_there_whatever_the_way_to_it():
    world = GymWorld(gymnasium.make("FrozenLake-v1", is_slippery=False), look=lambda env: int(env.unwrapped.s))
    truths = {}
    for way in ((), (2,), (2, 0), (1, 3)):
        world.reset(seed=7)
        for action in way:
            world.step(action)
        truths[way] = world.truth
    assert truths[2, 0] != truths[()] != truths[1, 3]
    assert [world.state_of(truth) for truth in truths.values()] == [0, 1, 0, 0]
    bandit = llf_teacher.make("llf-bandits-BanditTenArmedGaussian-v0").session.world
    bandit.reset(seed=7)
    assert bandit.state_of(bandit.truth) == bandit.truth


def test_an_environment_that_cannot_be_played_again_is_found_out():
    world = GymWorld(Lucky())
    lab = world.scratch()
    world.reset(seed=0)
    world.step(0)
    lab.restore(world.truth)
    with pytest.raises(RuntimeError, match="cannot be replayed: action 1 had another result"):
        lab.step(0)


def test_a_lab_that_cannot_be_made_asks_for_a_function():
    world = GymWorld(Stubborn())
    world.reset(seed=0)
    lab = world.scratch()
    lab.restore(world.truth)
    with pytest.raises(ValueError, match="pass a function that makes it"):
        lab.step(0)
    llf_teacher.teach(Stubborn()).reset(seed=0)  # rewards alone need no lab


def test_a_lab_that_differs_is_found_out():
    env = gymnasium.make("CartPole-v1")
    env.unwrapped.gravity = 1.0
    env.unwrapped.state = None
    world = GymWorld(env, snapshot="replay", look=lambda env: env.unwrapped.gravity)
    world.reset(seed=0)
    assert world.truth.seen == 1.0
    other = GymWorld(lambda: gymnasium.make("CartPole-v1"), snapshot="replay")
    other.reset(seed=1)
    other._episode.observation = world._observation
    lab = other.scratch()
    lab.restore(other.truth)
    with pytest.raises(RuntimeError, match="reset had another result"):
        lab.step(0)
