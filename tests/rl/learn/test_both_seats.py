"""Both seats at once: TorchRL and Tianshou on the AEC form, with a centralised critic where the library has one."""

import warnings

import numpy as np
import pettingzoo
import supersuit
import torch
from tensordict.nn import TensorDictModule
from tianshou.algorithm.modelfree.dqn import DQN, DiscreteQLearningPolicy
from tianshou.algorithm.multiagent.marl import MultiAgentOffPolicyAlgorithm
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv, PettingZooEnv
from tianshou.trainer import OffPolicyTrainerParams
from tianshou.utils.net.common import Net
from torchrl.envs.libs.pettingzoo import PettingZooWrapper
from torchrl.envs.utils import check_env_specs
from torchrl.modules import MLP

import llf_teacher  # noqa: F401 (registers the environments)

SEATS = {"speech": "kinds", "numbers": True, "teacher_numbers": True, "max_cycles": 8, "cost": 0.0}


def seats():
    return pettingzoo.make("aec", "llf/gridworld-v0", **SEATS)


def test_torchrl_plays_both_seats_and_a_critic_sees_all():
    torch.manual_seed(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it says which release of PettingZoo it was tested with
        env = PettingZooWrapper(seats(), use_mask=True, return_state=True, categorical_actions=True, seed=0)
        check_env_specs(env)
        rollout = env.rollout(40)
    assert rollout["teacher_0", "observation"].shape[-1] == 10
    assert rollout["student_0", "observation"].shape[-1] == 67
    masks, said = rollout["teacher_0", "action_mask"].squeeze(1), rollout["teacher_0", "action"].squeeze(1)
    turns = rollout["teacher_0", "mask"].flatten()
    assert turns.tolist() == [step % 2 == 0 for step in range(len(turns))]
    assert masks[turns][torch.arange(int(turns.sum())), said[turns]].all()  # nothing was said that could not be
    critic = TensorDictModule(MLP(in_features=rollout["state"].shape[-1], out_features=1), ["state"], ["value"])
    assert critic(rollout)["value"].shape == (*rollout.batch_size, 1)
    inner = env._env.unwrapped
    acts = next(field.place for field in inner.state_fields if field.name == "acts")
    assert torch.equal(rollout["state"][:, acts][:, 0] == 1, turns)


def learner(env):
    net = Net(state_shape=env.observation_space.shape, action_shape=env.action_space.n, hidden_sizes=(64,))
    spaces = {"action_space": env.action_space, "observation_space": env.observation_space}
    policy = DiscreteQLearningPolicy(model=net, eps_training=0.3, **spaces)
    return DQN(policy=policy, optim=AdamOptimizerFactory(lr=2e-3), gamma=0.8, target_update_freq=100)


def test_tianshou_trains_both_seats():
    """Its wrapper wants equal spaces, which SuperSuit's padding makes of them."""

    def make():
        return PettingZooEnv(supersuit.pad_action_space_v0(supersuit.pad_observations_v0(seats())))

    torch.manual_seed(0)
    env = make()
    learners = [learner(env), learner(env)]
    before = [each.policy.model.state_dict()["model.model.0.weight"].clone() for each in learners]
    algorithm = MultiAgentOffPolicyAlgorithm(algorithms=learners, env=env)
    collector = Collector(algorithm, DummyVectorEnv([make]), VectorReplayBuffer(2048, 1), exploration_noise=True)
    collector.reset()
    result = algorithm.run_training(
        OffPolicyTrainerParams(
            training_collector=collector,
            max_epochs=1,
            epoch_num_steps=400,
            collection_step_num_env_steps=8,
            update_step_num_gradient_steps_per_sample=0.25,
            batch_size=64,
            verbose=False,
            show_progress=False,
            multi_agent_return_reduction=lambda returns: returns.sum(axis=1),
        )
    )
    assert result.train_step >= 400
    after = [each.policy.model.state_dict()["model.model.0.weight"] for each in learners]
    assert all(not torch.equal(one, other) for one, other in zip(before, after, strict=True))
    assert np.isfinite(result.best_reward)
