"""Bandits: what the arms pay, which of them are best, what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worlds.bandits import PROBLEMS, Bandit, Truth

TWO_ARMED = {
    "TwoArmedDeterministicFixed": {0.0, 1.0},
    "TwoArmedHighHighFixed": {0.8, 0.9},
    "TwoArmedHighLowFixed": {0.2, 0.8},
    "TwoArmedLowLowFixed": {0.1, 0.2},
}
# Per problem how chances and payouts are drawn, and the spread of what is paid.
TEN_ARMED = {
    "TenArmedGaussian": ("one", "normal", 1.0),
    "TenArmedRandomFixed": ("uniform", "one", 0.0),
    "TenArmedRandomRandom": ("uniform", "uniform", 0.0),
    "TenArmedUniformDistributedReward": ("one", "uniform", 0.0),
}
SIGMAS = 5


def reset(problem, seed=0):
    world = Bandit(problem)
    world.reset(seed=seed)
    return world


def tied(*means):
    return Truth(means, (1.0,) * len(means), 0.0, means)


def test_there_are_eight_problems():
    assert set(PROBLEMS) == set(TWO_ARMED) | set(TEN_ARMED)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_arms_pay_their_expected_reward_on_average(problem):
    world = reset(problem, seed=1)
    chances, payouts, spread, means, *_ = world.truth
    pulls = 4000
    for arm, (chance, payout, mean) in enumerate(zip(chances, payouts, means, strict=True)):
        assert mean == pytest.approx(chance * payout)
        rewards = np.array([world.step(arm)[1] for _ in range(pulls)])
        variance = chance * (payout**2 + spread**2) - mean**2
        assert abs(rewards.mean() - mean) <= SIGMAS * np.sqrt(variance / pulls) + 1e-12
        if spread:
            assert rewards.std() == pytest.approx(spread, rel=0.1)
        else:
            assert set(rewards.tolist()) <= {0.0, payout}
            share, error = np.mean(rewards != 0), np.sqrt(chance * (1 - chance) / pulls)
            assert abs(share - chance) <= SIGMAS * error + 1e-12


@pytest.mark.parametrize(("problem", "chances"), TWO_ARMED.items())
def test_two_armed_problems_pay_one_with_fixed_chances_in_either_order(problem, chances):
    world = Bandit(problem)
    resets, greater_first = 400, 0
    for seed in range(resets):
        world.reset(seed=seed)
        truth = world.truth
        assert set(truth.chances) == chances
        assert truth.payouts == (1.0, 1.0)
        assert truth.spread == 0
        greater_first += truth.chances[0] > truth.chances[1]
    assert abs(greater_first - resets / 2) <= SIGMAS * np.sqrt(resets / 4)


@pytest.mark.parametrize(("problem", "chances", "payouts", "spread"), [(key, *row) for key, row in TEN_ARMED.items()])
def test_ten_armed_problems_redraw_every_arm_at_reset(problem, chances, payouts, spread):
    world = reset(problem)
    truths = []
    for _ in range(500):
        world.reset()
        truths.append(world.truth)
    assert {truth.spread for truth in truths} == {spread}
    for drawn, distribution in (([t.chances for t in truths], chances), ([t.payouts for t in truths], payouts)):
        table = np.array(drawn)
        assert table.shape == (500, 10)
        if distribution == "one":
            assert (table == 1).all()
            continue
        mean, deviation = (0.5, np.sqrt(1 / 12)) if distribution == "uniform" else (0.0, 1.0)
        assert np.abs(table.mean(axis=0) - mean).max() <= SIGMAS * deviation / np.sqrt(500)
        assert table.std() == pytest.approx(deviation, rel=0.05)
        assert len(np.unique(table)) == table.size
        if distribution == "uniform":
            assert table.min() >= 0
            assert table.max() <= 1


@pytest.mark.parametrize("problem", TEN_ARMED)
def test_every_arm_is_best_equally_often(problem):
    world = reset(problem)
    counts = np.zeros(10)
    for _ in range(1000):
        world.reset()
        counts[world.truth.best[0]] += 1
    assert np.sum((counts - 100) ** 2 / 100) < 33.7  # the 99.99 % quantile of chi-square with 9 degrees of freedom


@pytest.mark.parametrize("problem", PROBLEMS)
def test_success_is_pulling_an_arm_of_greatest_expected_reward(problem):
    world = reset(problem, seed=2)
    means = world.truth.means
    for arm, mean in enumerate(means):
        assert world.step(arm)[4] == {"success": mean == max(means)}


@pytest.mark.parametrize(
    ("means", "best"),
    [
        ((0.5, 0.5), (0, 1)),
        ((0.0, 0.0), (0, 1)),
        ((0.5, 0.4), (0,)),
        ((0.3,) * 10, tuple(range(10))),
        ((0.2, 0.7, 0.1, 0.7, *[0.0] * 5, 0.7), (1, 3, 9)),
    ],
)
def test_tied_arms_are_all_best(means, best):
    world = Bandit("TwoArmedLowLowFixed" if len(means) == 2 else "TenArmedRandomFixed")
    world.restore(tied(*means))
    assert world.truth.best == best
    assert [arm for arm in range(len(means)) if world.step(arm)[4]["success"]] == list(best)


def test_rewards_that_spread_stay_in_the_reward_range():
    world = Bandit("TenArmedGaussian")
    low, high = world.reward_range
    payouts = (99.9, -99.9, *[0.0] * 8)
    world.restore(Truth((1.0,) * 10, payouts, 1.0, payouts))
    most, least = [world.step(0)[1] for _ in range(200)], [world.step(1)[1] for _ in range(200)]
    assert max(most) == high
    assert min(least) == low


@pytest.mark.parametrize("problem", PROBLEMS)
def test_observation_is_empty_and_nothing_ends(problem):
    world = reset(problem)
    assert world.describe(0) == ""
    for turn in range(100):
        observation, _, terminated, truncated, _ = world.step(turn % world.arms)
        assert (observation, terminated, truncated) == (0, False, False)


@pytest.mark.parametrize("problem", ["TwoArmedHighLowFixed", "TenArmedGaussian"])
@pytest.mark.parametrize("action", [-1, 10, 10**9, 10**30, 0.0, 1.5, float("nan"), "0", None, [0], np.array([0, 1])])
def test_what_is_no_arm_is_refused_and_changes_nothing(problem, action):
    world = reset(problem)
    before = world.save()
    with pytest.raises(ValueError, match=rf"not in the action space; allowed: .* 0 to {world.arms - 1}; .* unchanged"):
        world.step(action)
    assert world.save() == before


@pytest.mark.parametrize("problem", PROBLEMS)
def test_arms_are_numbered_from_zero(problem):
    world = reset(problem)
    assert world.arms == (2 if problem in TWO_ARMED else 10)
    assert [world.legal(arm) for arm in range(world.arms)] == list(range(world.arms))
    with pytest.raises(ValueError, match=f"action {world.arms} is not in the action space"):
        world.step(world.arms)


@pytest.mark.parametrize("action", [1, np.int64(1), np.uint8(1), np.array(1)])
def test_an_arm_may_be_any_integer(action):
    world = reset("TwoArmedHighLowFixed")
    assert world.legal(action) == 1
    assert type(world.legal(action)) is int


def test_an_unknown_problem_is_refused_by_name():
    with pytest.raises(ValueError, match=r"problem 'OneArmed' is unknown; allowed: TenArmedGaussian, .*TwoArmedLowLow"):
        Bandit("OneArmed")
    with pytest.raises(ValueError, match="render_mode 'human' is unknown; allowed: None, ansi"):
        Bandit(render_mode="human")


@given(
    problem=st.sampled_from(sorted(PROBLEMS)),
    seed=st.integers(0, 2**32),
    before=st.lists(st.integers(0, 1), max_size=8),
    after=st.lists(st.integers(0, 1), max_size=8),
)
def test_restore_brings_back_arms_and_luck(problem, seed, before, after):
    world = reset(problem, seed)
    for arm in before:
        world.step(arm)
    saved = world.save()
    first = [world.step(arm) for arm in after]
    world.restore(saved)
    assert world.save() == saved
    assert [world.step(arm) for arm in after] == first


def test_restoring_a_truth_alone_leaves_the_luck_as_it_is():
    world, other = reset("TenArmedGaussian", 1), reset("TenArmedGaussian", 2)
    luck = world.save().random_state
    world.restore(other.truth)
    assert world.truth == other.truth
    assert world.save().random_state == luck


@pytest.mark.parametrize("problem", TEN_ARMED)
def test_seeds_decide_the_arms(problem):
    assert reset(problem, 3).truth == reset(problem, 3).truth
    assert reset(problem, 3).truth != reset(problem, 4).truth


def test_more_arms_than_the_problem_has():
    world = Bandit("TenArmedGaussian", arms=64)
    world.reset(seed=0)
    assert len(world.truth.means) == world.action_space.n == 64
    again = world.scratch()
    again.restore(world.truth)
    assert again.step(63)[0] == 0
    assert Bandit("TwoArmedLowLowFixed", arms=2).arms == 2
    for problem, arms, match in (
        ("TwoArmedLowLowFixed", 3, "has 2 arms, got arms=3; TenArmedGaussian"),
        ("TenArmedGaussian", 1, "arms must be an integer from 2 to 10,000, got 1"),
        ("TenArmedGaussian", True, "got True"),
    ):
        with pytest.raises(ValueError, match=match):
            Bandit(problem, arms=arms)
