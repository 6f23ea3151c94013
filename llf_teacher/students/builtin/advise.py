"""advise: learns from rewards, and uses praise and blame as evidence of the best action, not as rewards."""

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from llf_teacher.students.evaluated import Evaluated, EvaluatedPolicy, Features, Table, softmax
from teachers.spec import Range, Share


class _Policy(EvaluatedPolicy["Advise"]):
    """Q-values, and the balance of praise and blame."""

    def clear(self) -> None:
        """Forget everything."""
        self._values, self._balance = Table(self.actions, self.spec.optimism), Table(self.actions)

    def hear(self, turn: int, label: float) -> None:
        """Count the label."""
        state, action = self.steps[turn - 1]
        if label:
            self._balance.add(state, math.copysign(1.0, label), action)

    def learn(self, info: dict[str, Any], here: Features, over: bool) -> None:
        """One step of Q-learning."""
        spec, (state, action) = self.spec, self.steps[-1]
        target = info["reward"] + (0.0 if over else spec.gamma * float(self._values(here).max()))
        self._values.add(state, spec.alpha * (target - self._values(state)[action]), action)

    def choose(self, here: Features) -> int:
        """A draw from the product of two policies: one from rewards, one from praise and blame."""
        return int(self.rng.choice(self.actions, p=softmax(self._scores(here))))

    def _scores(self, here: Features) -> np.ndarray:
        spec = self.spec
        odds = self._balance(here) * math.log(spec.consistency / (1 - spec.consistency))
        return np.asarray(self._values(here) / spec.temperature - np.logaddexp(0.0, -odds))


@dataclass(frozen=True)
class Advise(Evaluated):
    """Policy shaping (Griffith et al. 2013).

    If a trainer is right with probability C and praised an action `d` times more often than it blamed it, the odds that
    this action is the best are `(C / (1 - C)) ** d`. The resulting policy is multiplied with that of Q-learning with
    Boltzmann exploration. The paper has Bayesian Q-learning, whose policy is an action's probability to be the best.
    """

    consistency: Annotated[float, Range(0.5, 1 - 1e-6)] = 0.8
    """Assumed probability that a verdict is right, 0.5 to below 1; 0.5: verdicts have no effect."""
    alpha: Share = 0.5
    """Step size, 0 to 1."""
    gamma: Share = 0.95
    """Discount factor, 0 to 1."""
    optimism: Annotated[float, Range(-1e9, 1e9)] = 0.0
    """Initial value of every action."""
    temperature: Annotated[float, Range(1e-9, math.inf)] = 0.05
    """Temperature of the Boltzmann policy, in units of value, above 0."""
    reads = "atoms and reward"
    policy = _Policy
