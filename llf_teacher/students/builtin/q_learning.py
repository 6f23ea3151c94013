"""q_learning: tabular Q-learning over discrete actions, from rewards, with or without advice."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Annotated, Any

from llf_teacher.students.learner import Learner, LearnerPolicy
from llf_teacher.students.student import frozen, state_of
from pz_envs.learning import StateValues
from teachers.spec import Range, Share


class _Policy(LearnerPolicy["QLearning"]):
    """A table of values per state."""

    def clear(self) -> None:
        """Start with an empty table."""
        self._actions = self.action_count
        self._values: dict[Any, list[float]] = {}

    def see(self, observation: dict[str, Any]) -> None:
        """Take in the state and find its values."""
        state = frozen(state_of(observation))
        self._here = self._values.setdefault(state, [self.spec.optimism] * self._actions)

    def learn(self, reward: float, over: bool) -> None:
        """One step of the method."""
        spec = self.spec
        row, action = self._last
        row[action] += spec.alpha * (reward + spec.gamma * (0.0 if over else max(self._here)) - row[action])

    def choose(self, wrong: Collection[Any] = ()) -> int:
        """An action of the greatest value, or with probability epsilon any; ties are broken at random."""
        allowed = [action for action in range(self._actions) if action not in wrong] or list(range(self._actions))
        if self.spec.epsilon and self.rng.random() < self.spec.epsilon:
            return allowed[self.rng.integers(len(allowed))]
        greatest = max(self._here[action] for action in allowed)
        best = [action for action in allowed if self._here[action] == greatest]
        return best[self.rng.integers(len(best))]

    def take(self, action: Any) -> None:
        """Note the state and the action."""
        self._last = self._here, int(action)

    def worth(self) -> list[float]:
        """The value of each action in the latest state."""
        return list(self._here)

    def recall(self, table: dict[Any, list[float]], here: Any, last: Any, action: int) -> None:
        """Take over a memory.

        Args:
            table: values per state.
            here: the latest state.
            last: the state before it.
            action: the action in that state.
        """
        self._values, self._here = table, table[here]
        self._last = table[last], action


@dataclass(frozen=True)
class QLearning(Learner):
    """Watkins & Dayan 1992, greedy on optimistic initial values, which make it explore untried actions."""

    alpha: Share = 0.5
    """Step size, 0 to 1."""
    gamma: Share = 0.95
    """Discount factor, 0 to 1."""
    optimism: Annotated[float, Range(-1e9, 1e9)] = 1.0
    """Initial value of every action."""
    epsilon: Share = 0.0
    """Probability of a random action in place of the greedy one, 0 to 1."""
    suits = StateValues
    policy = _Policy
    batch = "QLearners"
