"""RLlib: PPO on the student's seat in numbers."""

import gymnasium
import numpy as np
import pettingzoo
import pytest
import ray
import torch
from learning import follows, student
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core import Columns
from ray.rllib.env.wrappers.pettingzoo_env import PettingZooEnv
from ray.tune.registry import register_env


@pytest.fixture
def cluster():
    ray.init(num_cpus=1, include_dashboard=False, logging_level="ERROR")
    yield
    ray.shutdown()


def test_a_student_learns_to_follow_advice(cluster):
    register_env("student", lambda settings: student())
    config = (
        PPOConfig()
        .environment("student")
        .env_runners(num_env_runners=0)
        .learners(num_learners=0)
        .training(train_batch_size_per_learner=512, minibatch_size=64, num_epochs=10, lr=3e-3, gamma=0.8)
        .debugging(seed=0)
    )
    algorithm = config.build_algo()
    for _ in range(4):
        result = algorithm.train()
    assert result["num_env_steps_sampled_lifetime"] >= 2048
    module = algorithm.get_module()

    def act(observation):
        with torch.no_grad():
            out = module.forward_inference({Columns.OBS: torch.as_tensor(observation[np.newaxis])})
        return out[Columns.ACTION_DIST_INPUTS].argmax()

    assert follows(act) > 0.6
    algorithm.stop()


SPOKEN = {"feedback_type": "fp+fn", "cost": 1.0, "max_turns": 10, "teacher_numbers": True}
"""Silence is best, since each thing said costs as much as success is worth."""


def returned(act, seeds=range(20)):
    """The mean return of a teacher."""
    env, total = gymnasium.make("teacher/gridworld-v0", **SPOKEN), 0.0
    for seed in seeds:
        observation, _ = env.reset(seed=seed)
        done = False
        while not done:
            observation, reward, terminated, truncated, _ = env.step(int(act(observation)))
            total += reward
            done = terminated or truncated
    return total / len(seeds)


def test_a_teacher_learns_what_words_cost(cluster):
    register_env("teacher", lambda settings: gymnasium.make("teacher/gridworld-v0", **SPOKEN))
    config = (
        PPOConfig()
        .environment("teacher")
        .env_runners(num_env_runners=0)
        .learners(num_learners=0)
        .training(train_batch_size_per_learner=512, minibatch_size=64, num_epochs=10, lr=3e-3)
        .debugging(seed=0)
    )
    algorithm = config.build_algo()
    for _ in range(8):
        algorithm.train()
    module = algorithm.get_module()

    def act(observation):
        with torch.no_grad():
            out = module.forward_inference({Columns.OBS: torch.as_tensor(observation[np.newaxis])})
        return out[Columns.ACTION_DIST_INPUTS].argmax()

    assert returned(lambda observation: 3) < -5
    assert returned(act) > -1
    algorithm.stop()


def test_both_seats_learn_at_once(cluster):
    """By RLlib's own wrapper of AEC environments, a policy for each seat."""
    settings = {"speech": "kinds", "numbers": True, "teacher_numbers": True, "max_cycles": 8}
    register_env("seats", lambda _: PettingZooEnv(pettingzoo.make("aec", "llf/gridworld-v0", **settings)))
    config = (
        PPOConfig()
        .environment("seats")
        .env_runners(num_env_runners=0)
        .learners(num_learners=0)
        .multi_agent(policies={"teacher_0", "student_0"}, policy_mapping_fn=lambda agent, episode, **more: agent)
        .training(train_batch_size_per_learner=256, minibatch_size=64, num_epochs=2)
        .debugging(seed=0)
    )
    algorithm = config.build_algo()
    result = algorithm.train()
    assert result["learners"].keys() >= {"teacher_0", "student_0"}
    algorithm.stop()
