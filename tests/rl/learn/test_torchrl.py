"""TorchRL: DQN on the student's seat in numbers."""

import torch
from learning import follows, student
from tensordict.nn import TensorDictModule, TensorDictSequential
from torchrl.collectors import Collector
from torchrl.data import LazyTensorStorage, TensorDictReplayBuffer
from torchrl.envs import GymWrapper
from torchrl.envs.utils import check_env_specs
from torchrl.modules import MLP, EGreedyModule, QValueModule
from torchrl.objectives import DQNLoss, SoftUpdate


def test_a_student_learns_to_follow_advice():
    torch.manual_seed(0)
    env = GymWrapper(student(), categorical_action_encoding=True)
    env.set_seed(0)
    check_env_specs(env)
    size, actions = env.observation_spec["observation"].shape[-1], env.action_spec.space.n
    values = MLP(in_features=size, out_features=actions, num_cells=[64])
    policy = TensorDictSequential(
        TensorDictModule(values, in_keys=["observation"], out_keys=["action_value"]),
        QValueModule(spec=env.action_spec),
    )
    exploring = TensorDictSequential(policy, EGreedyModule(env.action_spec, eps_init=0.3, eps_end=0.3))
    loss = DQNLoss(policy, action_space=env.action_spec, delay_value=True)
    loss.make_value_estimator(gamma=0.8)
    target = SoftUpdate(loss, eps=0.98)
    optimizer = torch.optim.Adam(loss.parameters(), lr=2e-3)
    buffer = TensorDictReplayBuffer(storage=LazyTensorStorage(4096), batch_size=64)
    collector = Collector(env, exploring, frames_per_batch=64, total_frames=2048, device="cpu")
    for batch in collector:
        buffer.extend(batch)
        for _ in range(32):
            optimizer.zero_grad()
            loss(buffer.sample())["loss"].backward()
            optimizer.step()
            target.step()
    collector.shutdown()

    def act(observation):
        with torch.no_grad():
            return values(torch.as_tensor(observation)).argmax()

    assert follows(act) > 0.6
