"""The bandits' oracle: every tied arm is right."""

import numpy as np
import pytest
from moments import opening, started, turn

from teachers.atoms import FN, HN, HP
from teachers.oracles.bandits import Avoid, BanditOracle, Goal, Pull, PulledBest, PulledPoor, Random, Steady
from worlds.bandits import PROBLEMS, Bandit
from worlds.bandits import Truth as Arms


@pytest.mark.parametrize(("means", "best"), [((0.5, 0.5), {0, 1}), ((0.0, 0.0), {0, 1}), ((0.5, 0.25), {0})])
def test_tied_arms_are_all_right(means, best):
    truth = Arms(means, (1.0, 1.0), 0.0, means)
    world = Bandit("TwoArmedHighLowFixed")
    oracle, lab = started(BanditOracle, world, truth), world.scratch()
    for arm in range(2):
        moment = turn(world, truth, arm)
        (verdict,) = oracle.judge(moment, frozenset((HP, HN)))
        assert type(verdict) is (PulledBest if arm in best else PulledPoor)
        assert verdict.holds(moment, lab)
        assert Pull(action=arm).holds(moment, lab) == (arm in best)
        assert Avoid(action=arm).holds(moment, lab) == (arm not in best)
        assert (oracle.regret(moment) == 0) == (arm in best)
    warned = {claim.action for n in range(4) for claim in oracle.judge(moment._replace(turn=n), frozenset((FN,)))}
    assert warned == {0, 1} - best
    assert all(
        claim.holds(opening(truth), lab)
        for each in "bpc"
        for claim in oracle.brief(truth, each, np.random.default_rng(0))
    )


def test_a_verdict_is_on_the_arm_that_was_pulled():
    means = (0.9, 0.9, 0.1, 0.1, *[0.2] * 6)
    truth, world = Arms(means, (1.0,) * 10, 0.0, means), Bandit("TenArmedRandomFixed")
    started(BanditOracle, world, truth)
    lab = world.scratch()
    for verdict, arms in ((PulledBest, (0, 1)), (PulledPoor, (2, 3))):
        for arm in arms:
            assert [each for each in range(10) if verdict(action=each).holds(turn(world, truth, arm), lab)] == [arm]
            assert not verdict(action=arm).holds(opening(truth), lab)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_chance_is_spoken_of_where_arms_pay_by_chance_only(problem):
    world = Bandit(problem)
    world.reset(seed=0)
    steady = problem in ("TwoArmedDeterministicFixed", "TenArmedUniformDistributedReward")
    said, lab = started(BanditOracle, world, world.truth).brief(world.truth, "b"), world.scratch()
    assert said[:2] == (Goal(arms=world.arms), Steady() if steady else Random())
    for arms in (world.arms - 1, world.arms + 1):
        assert not Goal(arms=arms).holds(opening(world.truth), lab)
    assert Steady().holds(opening(world.truth), lab) == steady
    assert Random().holds(opening(world.truth), lab) != steady


def test_warnings_go_through_all_poor_arms():
    world = Bandit("TenArmedRandomFixed")
    means = (0.1, 0.9, 0.2, 0.9, *[0.3] * 6)
    oracle = started(BanditOracle, world, Arms(means, (1.0,) * 10, 0.0, means))
    moments = [opening(world.truth)._replace(turn=n) for n in range(8)]
    assert {oracle.judge(moment)[-1].action for moment in moments} == set(range(10)) - {1, 3}
