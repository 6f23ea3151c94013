"""dqn: Q-learning with a neural network, for states too many for a table; from rewards, with or without advice."""

import importlib.util
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

import numpy as np
from gymnasium import spaces
from gymnasium.spaces.utils import flatten, flatten_space

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.student import state_of
from pz_envs.subject import Subject
from teachers.spec import Range, Share
from worlds.actions import describe_space
from worlds.extras import pip_install
from worlds.world import World

_BATCH = 32


class _Transition(NamedTuple):
    """A transition in the memory."""

    state: np.ndarray
    action: int
    reward: float
    after: np.ndarray
    goes_on: float
    """1, or 0 if the state after it is terminal."""


class _Policy(LearnerPolicy["Dqn"]):
    """A network, an older copy of it for the targets, and a memory of transitions."""

    def __init__(self, spec: "Dqn", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        check_torch()
        self._actions = self.action_count
        space = flatten_space(world.observation_space) if world.observation_space.is_np_flattenable else None
        if not isinstance(space, spaces.Box) or space.shape is None:
            raise ValueError(
                f"the student {spec} needs states that are numbers; those of {family.name} are "
                f"{describe_space(world.observation_space)}"
            )
        low, high = space.low.astype(float), space.high.astype(float)
        bounded = (low > -1e9) & (high < 1e9) & (low < high)
        self._middle = np.where(bounded, (low + high) / 2, 0.0)
        self._reach = np.where(bounded, (high - low) / 2, 1.0)

    def clear(self) -> None:
        """Forget everything: small random weights, and an empty memory."""
        from torch.optim import Adam

        self._network, self._target = self._untrained(), self._untrained()
        self._target.load_state_dict(self._network.state_dict())
        self._adam = Adam(self._network.parameters(), lr=self.spec.alpha)
        self._memory: list[_Transition] = []
        self._lessons = 0

    def see(self, observation: dict[str, Any]) -> None:
        """Take in the state as numbers, scaled to -1 to 1 where it has bounds."""
        numbers = np.asarray(flatten(self.world.observation_space, state_of(observation)), float)
        self._here = ((numbers - self._middle) / self._reach).astype(np.float32)

    def learn(self, reward: float, over: bool) -> None:
        """Add the transition to the memory, and learn from a sample of it."""
        move = _Transition(*self._last, reward, self._here, float(not over))
        if len(self._memory) < self.spec.memory:
            self._memory.append(move)
        else:
            self._memory[self._lessons % self.spec.memory] = move
        self._lessons += 1
        if len(self._memory) >= _BATCH:
            self._study([self._memory[i] for i in self.rng.integers(len(self._memory), size=_BATCH)])
        if self._lessons % self.spec.sync == 0:
            self._target.load_state_dict(self._network.state_dict())

    def choose(self, wrong: Collection[Any] = ()) -> int:
        """An action of the greatest value, or with probability epsilon any action."""
        allowed = [action for action in range(self._actions) if action not in wrong] or list(range(self._actions))
        if self.spec.epsilon and self.rng.random() < self.spec.epsilon:
            return allowed[self.rng.integers(len(allowed))]
        worth = self.worth()
        return max(allowed, key=worth.__getitem__)

    def take(self, action: Any) -> None:
        """Note the state and the action."""
        self._last = self._here, int(action)

    def worth(self) -> list[float]:
        """The value of each action in the latest state."""
        import torch

        with torch.no_grad():
            values: list[float] = self._network(torch.as_tensor(self._here)).tolist()
        return values

    def _untrained(self) -> Any:
        """A network of two hidden layers, with weights from the student's own random stream."""
        import torch
        from torch import nn

        sizes = (len(self._middle), self.spec.hidden, self.spec.hidden, self._actions)
        layers: list[Any] = []
        for inputs, outputs in pairwise(sizes):
            layer = nn.utils.skip_init(nn.Linear, inputs, outputs)
            with torch.no_grad():
                for weights in layer.parameters():
                    drawn = self.rng.uniform(-1, 1, tuple(weights.shape)) / np.sqrt(inputs)
                    weights.copy_(torch.as_tensor(drawn))
            layers += [layer, nn.ReLU()]
        return nn.Sequential(*layers[:-1])

    def _study(self, moves: list[_Transition]) -> None:
        """A gradient step towards the targets of these transitions."""
        import torch

        states, actions, rewards, after, goes_on = zip(*moves, strict=True)
        with torch.no_grad():
            best = self._target(torch.as_tensor(np.stack(after))).max(dim=1).values
            target = torch.tensor(rewards) + self.spec.gamma * torch.tensor(goes_on) * best
        values = self._network(torch.as_tensor(np.stack(states)))
        found = values.gather(1, torch.tensor(actions)[:, None])[:, 0]
        self._adam.zero_grad()
        torch.nn.functional.smooth_l1_loss(found, target).backward()
        self._adam.step()


@dataclass(frozen=True)
class Dqn(Learner):
    """A deep Q-network (Mnih et al. 2015) over discrete actions, for states that are numbers; needs the extra `learn`.

    It learns once per turn, from a sample of its memory; states are scaled to their bounds.
    """

    alpha: Share = 1e-3
    """Step size of Adam, 0 to 1."""
    gamma: Share = 0.95
    """Discount factor, 0 to 1."""
    epsilon: Share = 0.1
    """Probability of a random action in place of the greedy one, 0 to 1."""
    hidden: Annotated[int, Range(1, 4096)] = 64
    """Width of both hidden layers, 1 to 4096."""
    memory: Annotated[int, Range(_BATCH, 10**6)] = 10_000
    """Size of the memory in transitions, 32 to 1000000; the oldest is replaced."""
    sync: Annotated[int, Range(1, 10**6)] = 100
    """Number of turns between updates of the target network, 1 to 1000000."""
    policy = _Policy

    def check(self, environment: Mapping[str, str]) -> None:
        """Check that the extra is installed."""
        check_torch()


def check_torch() -> None:
    """Check that torch is installed.

    Raises:
        ModuleNotFoundError: the extra is not installed; the message has the pip line.
    """
    if importlib.util.find_spec("torch") is None:
        raise ModuleNotFoundError(
            f"the student dqn needs 'torch', which is not installed; run: {pip_install('learn')}",
            name="torch",
        )
