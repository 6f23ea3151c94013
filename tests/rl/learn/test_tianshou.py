"""Tianshou: DQN on the student's seat in numbers."""

import torch
from learning import GRID, follows, student
from tianshou.algorithm.modelfree.dqn import DQN, DiscreteQLearningPolicy
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv
from tianshou.trainer import OffPolicyTrainerParams
from tianshou.utils.net.common import Net


def test_a_student_learns_to_follow_advice():
    torch.manual_seed(0)
    single = student()
    envs = DummyVectorEnv([student] * 2)
    envs.seed(0)
    net = Net(state_shape=single.observation_space.shape, action_shape=single.action_space.n, hidden_sizes=(64,))
    policy = DiscreteQLearningPolicy(
        model=net, action_space=single.action_space, observation_space=single.observation_space, eps_training=0.3
    )
    algorithm = DQN(policy=policy, optim=AdamOptimizerFactory(lr=2e-3), gamma=0.8, target_update_freq=100)
    collector = Collector(algorithm, envs, VectorReplayBuffer(4096, 2), exploration_noise=True)
    collector.reset()
    before = follows(policy.compute_action, GRID)
    result = algorithm.run_training(
        OffPolicyTrainerParams(
            training_collector=collector,
            max_epochs=1,
            epoch_num_steps=1536,
            collection_step_num_env_steps=8,
            update_step_num_gradient_steps_per_sample=0.25,
            batch_size=64,
            verbose=False,
            show_progress=False,
        )
    )
    assert result.train_step >= 1536
    assert follows(policy.compute_action, GRID) > max(0.6, before)
