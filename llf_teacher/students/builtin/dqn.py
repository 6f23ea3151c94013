"""dqn: Q-learning with a neural network, for states that no table can list; from rewards, with or without advice."""

import importlib.util
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces
from gymnasium.spaces.utils import flatten, flatten_space

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.student import state_of
from pz_envs.subject import Subject
from teachers.spec import check_range
from worlds.world import World

_BATCH = 32


class _Move(NamedTuple):
    """What is remembered of a turn."""

    state: np.ndarray
    action: int
    reward: float
    after: np.ndarray
    goes_on: float
    """1, or 0 if the state after it is terminal."""


class _Policy(LearnerPolicy["Dqn"]):
    """A network, an elder copy of it that gives the targets, and a memory of moves."""

    def __init__(self, spec: "Dqn", family: Subject, world: World[Any]) -> None:
        super().__init__(spec, family, world)
        check_torch()
        self._actions = self.action_count
        space = flatten_space(world.observation_space) if world.observation_space.is_np_flattenable else None
        if not isinstance(space, spaces.Box) or space.shape is None:
            raise ValueError(
                f"the student {spec} needs states that are numbers; those of {family.name} are "
                f"{world.observation_space}"
            )
        low, high = space.low.astype(float), space.high.astype(float)
        bounded = (low > -1e9) & (high < 1e9) & (low < high)
        self._middle = np.where(bounded, (low + high) / 2, 0.0)
        self._reach = np.where(bounded, (high - low) / 2, 1.0)

    def clear(self) -> None:
        """Know nothing: small random weights, and no memory."""
        from torch.optim import Adam

        self._network, self._elder = self._untrained(), self._untrained()
        self._elder.load_state_dict(self._network.state_dict())
        self._adam = Adam(self._network.parameters(), lr=self.spec.alpha)
        self._memory: list[_Move] = []
        self._lessons = 0

    def see(self, observation: dict[str, Any]) -> None:
        """The state as numbers from -1 to 1, where it has bounds."""
        numbers = np.asarray(flatten(self.world.observation_space, state_of(observation)), float)
        self._here = ((numbers - self._middle) / self._reach).astype(np.float32)

    def learn(self, reward: float, over: bool) -> None:
        """Remember the move, and learn from some that are remembered."""
        move = _Move(*self._last, reward, self._here, float(not over))
        if len(self._memory) < self.spec.memory:
            self._memory.append(move)
        else:
            self._memory[self._lessons % self.spec.memory] = move
        self._lessons += 1
        if len(self._memory) >= _BATCH:
            self._study([self._memory[i] for i in self.rng.integers(len(self._memory), size=_BATCH)])
        if self._lessons % self.spec.sync == 0:
            self._elder.load_state_dict(self._network.state_dict())

    def choose(self, wrong: Collection[Any] = ()) -> int:
        """A greatest value, or with probability epsilon any action."""
        allowed = [action for action in range(self._actions) if action not in wrong] or list(range(self._actions))
        if self.spec.epsilon and self.rng.random() < self.spec.epsilon:
            return allowed[self.rng.integers(len(allowed))]
        worth = self.worth()
        return max(allowed, key=worth.__getitem__)

    def take(self, action: Any) -> None:
        """Remember where it was taken."""
        self._last = self._here, int(action)

    def worth(self) -> list[float]:
        """What it holds the actions to be worth in the state that was seen last."""
        import torch

        with torch.no_grad():
            values: list[float] = self._network(torch.as_tensor(self._here)).tolist()
        return values

    def _untrained(self) -> Any:
        """Two hidden layers, with weights of the student's own draw: no stream is shared with anybody."""
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

    def _study(self, moves: list[_Move]) -> None:
        """A step towards what the elder network makes of these moves."""
        import torch

        states, actions, rewards, after, goes_on = zip(*moves, strict=True)
        with torch.no_grad():
            best = self._elder(torch.as_tensor(np.stack(after))).max(dim=1).values
            target = torch.tensor(rewards) + self.spec.gamma * torch.tensor(goes_on) * best
        values = self._network(torch.as_tensor(np.stack(states)))
        found = values.gather(1, torch.tensor(actions)[:, None])[:, 0]
        self._adam.zero_grad()
        torch.nn.functional.smooth_l1_loss(found, target).backward()
        self._adam.step()


@dataclass(frozen=True)
class Dqn(Learner):
    """A deep Q-network (Mnih et al. 2015) over discrete actions, for states that are numbers; needs the extra `learn`.

    It learns once a turn, from moves that it draws from its memory; states are scaled to their bounds.
    """

    alpha: float = 1e-3
    """Step size of Adam, 0 to 1."""
    gamma: float = 0.95
    """Discount factor, 0 to 1."""
    epsilon: float = 0.1
    """Probability of a random action in place of the greedy one, 0 to 1."""
    hidden: int = 64
    """Width of both hidden layers, 1 to 4096."""
    memory: int = 10_000
    """Moves that it remembers, 32 to 1000000; then the oldest is forgotten."""
    sync: int = 100
    """Turns after which the targets are brought up to date, 1 to 1000000."""
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("alpha", "gamma", "epsilon"):
            check_range(name, getattr(self, name), 0, 1)
        check_range("hidden", self.hidden, 1, 4096, int)
        check_range("memory", self.memory, _BATCH, 10**6, int)
        check_range("sync", self.sync, 1, 10**6, int)

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure that the extra is installed."""
        check_torch()


def check_torch() -> None:
    """Make sure that networks can be trained.

    Raises:
        ModuleNotFoundError: the extra is not installed; the message has the pip line.
    """
    if importlib.util.find_spec("torch") is None:
        raise ModuleNotFoundError(
            "the student dqn needs 'torch', which is not installed; run: pip install 'llf-teacher[learn]'",
            name="torch",
        )
