"""ucb: upper confidence bounds over discrete actions, for worlds without a state."""

import math
from dataclasses import dataclass
from typing import Any

from llf_teacher.student import Policy, Student
from teachers.spec import check_range


@dataclass(frozen=True)
class Ucb(Student):
    """UCB1 (Auer, Cesa-Bianchi & Fischer 2002): mean reward plus `scale * sqrt(2 ln t / n)`; each action once first."""

    scale: float = 0.5
    """Width of the bound, in units of reward, at least 0."""
    reads = "reward"

    def __post_init__(self) -> None:
        check_range("scale", self.scale, 0, math.inf)

    class Policy(Policy):
        """Counts and sums per action."""

        def begin(self) -> None:
            """Nothing tried; the order of first tries is random."""
            arms = int(self.world.action_space.n)  # type: ignore[attr-defined]
            self._count, self._sum = [0] * arms, [0.0] * arms
            self._untried = self.rng.permutation(arms).tolist()
            self._last: int | None = None

        def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
            """The action of the greatest bound."""
            if self._last is not None:
                self._count[self._last] += 1
                self._sum[self._last] += info["reward"]
            self._last = self._untried.pop() if self._untried else self._greatest()
            return self._last

        def _greatest(self) -> int:
            log = 2 * math.log(sum(self._count))
            bounds = [s / n + self.spec.scale * math.sqrt(log / n) for s, n in zip(self._sum, self._count, strict=True)]
            return bounds.index(max(bounds))
