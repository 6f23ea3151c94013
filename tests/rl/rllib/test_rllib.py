"""RLlib: PPO on the student's seat in numbers."""

import numpy as np
import pytest
import ray
import torch
from learning import follows, student
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.core import Columns
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
