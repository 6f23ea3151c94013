"""Meta-World's trials: what is foreseen is what comes, for less work."""

import sys

import numpy as np
import pytest

from worlds.metaworld import TASKS, MetaWorld

SAMPLE = ("bin-picking-v3", "door-lock-v3", "drawer-open-v3", "pick-place-v3", "stick-push-v3")
EVERY_TASK = [pytest.param(task, marks=() if task in SAMPLE else pytest.mark.full) for task in TASKS]


@pytest.mark.parametrize("task", EVERY_TASK)
def test_a_trial_finds_the_same_success(task):
    """Up to where the scripted policy solves the task, if it does, and with what it does not want."""
    world, rng = MetaWorld(task), np.random.default_rng(4)
    for seed in range(2):
        world.reset(seed=seed)
        for _ in range(30):
            aim = world.script.aim(world.truth.observation)
            wanted = world.legal([*aim.target, aim.grip])
            other = world.legal(world.sample_action(rng))
            for action in (other, wanted):
                begun = world.truth
                foreseen = world.foresee(begun, action)
                world.advance(action)
                assert foreseen == (world.truth.observation[:3], world.truth.solved)
                if action is other:
                    world.restore(begun)
            if world.truth.solved:
                break


@pytest.mark.parametrize("task", EVERY_TASK)
def test_turns_are_metaworlds_low_level_steps_to_the_last_bit(task):
    world, rng, actions, ends = MetaWorld(task), np.random.default_rng(6), [], []
    world.reset(seed=1)
    for turn in range(12):
        aim = world.script.aim(world.truth.observation)
        actions.append(world.legal([*aim.target, aim.grip] if turn % 4 else world.sample_action(rng)))
        _, reward, *_ = world.step(actions[-1])
        ends.append((world.truth.observation, reward))
    original = world.original(actions, 1)
    original.reset()
    for action, end in zip(actions, ends, strict=True):
        observation, reward, *_ = original.step(action)
        assert (tuple(observation.tolist()), reward) == end


@pytest.mark.parametrize("task", EVERY_TASK)
def test_success_is_metaworlds(task, monkeypatch):
    """At every low-level step of turns that solve the task, if the scripted policy does, and of others before."""
    world, rng, checked = MetaWorld(task), np.random.default_rng(5), 0
    world.reset(seed=0)
    simulator = world.simulator()
    env, solves = simulator.env, simulator.probe.solves

    def checked_solves(seen, command):
        nonlocal checked
        checked += 1
        solved = solves(seen, command)
        assert solves(seen[:3], command) == solved
        assert solved == bool(env.evaluate_state(np.array(seen), np.array(command))[1]["success"])
        return solved

    monkeypatch.setattr(type(simulator.probe), "solves", lambda probe, *args: checked_solves(*args))
    for seed in range(2):
        world.reset(seed=seed)
        for turn in range(30):
            aim = world.script.aim(world.truth.observation)
            wanted = world.legal([*aim.target, aim.grip])
            world.advance(wanted if seed or turn % 5 else world.legal(world.sample_action(rng)))
            if world.truth.solved:
                break
    assert checked > 30


def calls(function, *args):
    """How many functions are called."""
    count = 0

    def called(frame, event, of):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(called)
    try:
        function(*args)
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize(("task", "most"), [("push-v3", 0.85), ("reach-v3", 0.85)])
def test_a_trial_observes_no_more_than_it_needs(task, most):
    world = MetaWorld(task)
    world.reset(seed=0)
    action = (0.3, 0.6, 0.2, 0.0)
    world.step(action)
    assert calls(world.foresee, world.truth, action) < most * calls(world.advance, action)


def test_rewards_are_worked_out_once_a_turn(monkeypatch):
    world, rewarded = MetaWorld("push-v3"), []
    world.reset(seed=0)
    env = type(world.simulator().env)
    evaluate = env.evaluate_state
    monkeypatch.setattr(env, "evaluate_state", lambda *args: rewarded.append(args) or evaluate(*args))
    world.foresee(world.truth, (0.3, 0.6, 0.2, 0.0))
    assert not rewarded
    _, reward, *_ = world.step([0.3, 0.6, 0.2, 0.0])
    assert len(rewarded) == 1
    assert reward == evaluate(*rewarded[0])[0]
