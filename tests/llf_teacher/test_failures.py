"""What a text that is no action costs: it does not pay to answer nonsense."""

import numpy as np
import pytest
from playing import earned

import llf_teacher
import llf_teacher.compat as llfbench
from llf_teacher.registry import entry
from pz_envs.family import own_families
from teachers.atoms import Moment, ParseFailure
from worlds.bandits import Bandit
from worlds.optimization import Optimization

ENVIRONMENTS = [f"llf-{name}" for family in own_families() for name in (family.sampled or tuple(family.environments))]
QUICK = [f"llf-{family.showcase[0]}" for family in own_families()]
TURNS = 4


def returns(id, answer, seed, **options):
    """The rewards of always answering one thing."""
    return earned(llf_teacher.make(id, text=True, max_turns=TURNS, feedback_type="n", **options), answer, seed)


def written(world, action):
    return action if isinstance(action, str) else str(list(action) if isinstance(action, tuple) else int(action))


@pytest.mark.parametrize("id", ENVIRONMENTS)
def test_in_no_state_does_a_failure_pay_more_than_every_action(id):
    found = entry(id)
    world, rng = found.family.make_world(**found.options), np.random.default_rng(0)
    oracle = found.family.make_teacher(world).oracle
    for seed in range(1 if found.family.slow else 3):
        world.reset(seed=seed)
        oracle.start(world.truth)
        for _ in range(2):
            lab, paid = world.scratch(), []
            tried = [lab.sample_action(rng) for _ in range(2 if found.family.slow else 20)]
            for action in (*tried, *oracle.plan(world.truth, 1)):
                lab.restore(world.save())
                paid.append(lab.step(action)[1])
            assert world.failure_reward <= max(paid)
            low, high = world.reward_range
            assert low <= world.failure_reward <= high
            world.step(world.sample_action(rng))


@pytest.mark.parametrize("id", QUICK)
def test_nonsense_earns_no_more_than_a_sensible_answer(id):
    found = entry(id)
    world = found.family.make_world(**found.options)
    for seed in range(1 if found.family.slow else 3):
        world.reset(seed=seed)
        oracle = found.family.make_teacher(world).oracle
        oracle.start(world.truth)
        answer = written(world, world.legal(oracle.plan(world.truth, 1)[0]))
        assert returns(id, "\x00", seed) <= returns(id, answer, seed)


def test_in_optimization_to_stay_pays_more_than_nonsense():
    id = "llf-optimization-Rosenbrock-v0"
    for seed in range(10):
        assert returns(id, "hm", seed) < returns(id, "stay", seed)


def test_no_arm_pays_less_than_nonsense():
    world = Bandit("TenArmedGaussian")
    below = 0
    for seed in range(20):
        world.reset(seed=seed)
        assert world.failure_reward == min(0.0, *world.truth.means)
        below += world.failure_reward < 0
    assert below > 10


def idle(id, seed=0):
    found = entry(id)
    world = found.family.make_world(**found.options)
    world.reset(seed=seed)
    oracle = found.family.make_teacher(world).oracle
    oracle.start(world.truth)
    unread = Moment.unread(world.truth, ParseFailure("hm", world.action_syntax), world.failure_reward, False, 1, False)
    return world, oracle, oracle.regret(unread)


def test_the_regret_of_a_failure_is_that_of_what_happened():
    world, oracle, regret = idle("llf-gridworld-v0")
    assert regret == 1.0
    world, oracle, regret = idle("llf-optimization-Booth-v0")
    before = world.truth
    reward = world.step("stay")[1]
    assert regret == pytest.approx(oracle.regret(Moment(before, before.x, reward, world.truth, False, 1, False)))
    world, oracle, regret = idle("llf-highway-parking-v0")
    assert regret == 1.0
    world, oracle, regret = idle("llf-bandits-BanditTwoArmedHighLowFixed-v0")
    assert regret == 0.8


@pytest.mark.parametrize("value", [-3.5, 0.0])
def test_what_a_failure_pays_can_be_told(value):
    assert returns("llf-highway-parking-v0", "hm", 0, failure_reward=value) == TURNS * value


@pytest.mark.parametrize("value", [0.5, -7, float("nan"), "0", True])
def test_what_is_no_reward_is_refused(value):
    with pytest.raises(ValueError, match=r"failure_reward must be None .* of its reward range, -6 to 0, got"):
        llf_teacher.make("llf-highway-parking-v0", failure_reward=value)


def test_compat_pays_what_llf_bench_pays_unless_told_otherwise():
    for options, paid in (({}, -0.01), ({"failure_reward": -5.0}, -5.0)):
        env = llfbench.make("llf-optimization-Booth-v0", **options)
        env.reset(seed=0)
        assert env.step("hm")[1] == paid
    assert Optimization().failure_reward == Optimization().reward_range[0]
