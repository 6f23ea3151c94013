"""ucb: upper confidence bounds over discrete actions, for worlds without a state, with or without advice."""

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Annotated, Any

from llf_teacher.students.learner import Learner, LearnerPolicy
from pz_envs.learning import ActionValues
from teachers.spec import Range


class _Policy(LearnerPolicy["Ucb"]):
    """Counts and sums per action."""

    def clear(self) -> None:
        """Forget everything; the order of the first actions is random."""
        arms = self.action_count
        self._count, self._sum = [0] * arms, [0.0] * arms
        self._untried: list[int] = self.rng.permutation(arms).tolist()

    def learn(self, reward: float, over: bool) -> None:
        """Count the reward."""
        if self._last in self._untried:
            self._untried.remove(self._last)
        self._count[self._last] += 1
        self._sum[self._last] += reward

    def choose(self, wrong: Collection[Any] = ()) -> int:
        """The next untried action, else an action of the greatest bound."""
        untried = [arm for arm in self._untried if arm not in wrong]
        if untried:
            return untried[-1]
        tried = [arm for arm, count in enumerate(self._count) if count and arm not in wrong]
        if not tried:  # warnings name all actions
            return self._untried[-1] if self._untried else self._last
        log = 2 * math.log(sum(self._count))
        scale = self.spec.scale
        bounds = {arm: self._sum[arm] / n + scale * math.sqrt(log / n) for arm in tried if (n := self._count[arm])}
        return max(bounds, key=bounds.__getitem__)

    def recall(self, count: list[int], total: list[float], untried: list[int], last: int) -> None:
        """Take over a memory.

        Args:
            count: per action how often its reward was counted.
            total: per action the sum of its rewards.
            untried: the actions that have no reward yet, the next one last.
            last: the last action.
        """
        self._count, self._sum, self._untried = count, total, untried
        self.take(last)

    def take(self, action: Any) -> None:
        """Note the action; an advised action counts as tried."""
        self._last: int = int(action)


@dataclass(frozen=True)
class Ucb(Learner):
    """UCB1 (Auer, Cesa-Bianchi & Fischer 2002): mean reward plus `scale * sqrt(2 ln t / n)`; each action once first."""

    scale: Annotated[float, Range(0, math.inf)] = 0.5
    """Width of the bound, in units of reward, at least 0."""
    suits = ActionValues
    policy = _Policy
    batch = "Ucbs"
