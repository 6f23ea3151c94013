"""q_learning: tabular Q-learning over discrete actions, from rewards alone."""

from dataclasses import dataclass
from typing import Any

from llf_teacher.student import Policy, Student, frozen, state_of
from teachers.spec import check_range


@dataclass(frozen=True)
class QLearning(Student):
    """Watkins & Dayan 1992, greedy on optimistic initial values, so that it explores what it has not tried."""

    alpha: float = 0.5
    """Step size, 0 to 1."""
    gamma: float = 0.95
    """Discount factor, 0 to 1."""
    optimism: float = 1.0
    """Initial value of every action."""
    forget: bool = True
    """Whether each episode starts with an empty table, as it should where each is another world."""
    reads = "reward"

    def __post_init__(self) -> None:
        check_range("alpha", self.alpha, 0, 1)
        check_range("gamma", self.gamma, 0, 1)
        check_range("optimism", self.optimism, -1e9, 1e9)

    class Policy(Policy):
        """A table of values per state."""

        def begin(self) -> None:
            """Start with an empty table, or with what is known."""
            if self.spec.forget or not hasattr(self, "_values"):
                self._values: dict[Any, list[float]] = {}
            self._last: tuple[list[float], int] | None = None

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """Learn from the last transition, then take a greatest value; ties are broken at random."""
            spec = self.spec
            actions = int(self.world.action_space.n)  # type: ignore[attr-defined]
            values = self._values.setdefault(frozen(state_of(observation)), [spec.optimism] * actions)
            if self._last is not None:
                row, action = self._last
                row[action] += spec.alpha * (info["reward"] + spec.gamma * max(values) - row[action])
            best = [action for action, value in enumerate(values) if value == max(values)]
            choice = best[self.rng.integers(len(best))]
            self._last = values, choice
            return choice
