"""sabl: infers the best action from praise, blame and silence, with a known or inferred strategy of the trainer."""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from llf_teacher.students.evaluated import Evaluated, EvaluatedPolicy, Features
from teachers.spec import Range, Share

_SHARES = np.linspace(0.05, 0.95, 10)
GRID = np.tile(_SHARES, 10), np.repeat(_SHARES, 10)
"""Probabilities of silence after right and after wrong actions where they are inferred, shape (strategies,) both."""


def log_chances(error: Any, plus: NDArray[np.float64], minus: NDArray[np.float64]) -> NDArray[np.float64]:
    """Log-likelihoods of labels.

    Args:
        error: a probability, or several that broadcast with the others.
        plus, minus: probabilities of silence, shape (..., strategies).

    Returns:
        By whether the action was the best, and by blame, silence and praise: shape (2, 3, ..., strategies).
    """
    right = np.stack([error * (1 - minus), (1 - error) * plus + error * minus, (1 - error) * (1 - plus)])
    wrong = np.stack([(1 - error) * (1 - minus), (1 - error) * minus + error * plus, error * (1 - plus)])
    return np.asarray(np.log(np.maximum(np.stack([wrong, right]), 1e-12)))


class _Policy(EvaluatedPolicy["Sabl"]):
    """Log-likelihoods of all labels in a state, per action that may be best and per strategy."""

    def clear(self) -> None:
        """Forget all labels."""
        self._log = log_chances(self.spec.error, *self.strategies())
        self._heard: dict[Hashable, NDArray[np.float64]] = {}

    def strategies(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Probabilities of silence after right and after wrong actions, shape (strategies,) both."""
        return GRID if self.spec.infers else (np.array([self.spec.plus]), np.array([self.spec.minus]))

    def recall(self, heard: dict[Hashable, NDArray[np.float64]], silent: set[int]) -> None:
        """Take over a memory.

        Args:
            heard: per state with labels the log-likelihoods, shape (actions, strategies).
            silent: the turns that count as silence.
        """
        self._heard, self._silent = heard, silent

    def begin(self) -> None:
        """Begin an episode."""
        super().begin()
        self._silent = set[int]()
        """The turns that count as silence."""

    def hear(self, turn: int, label: float) -> None:
        """Update the likelihoods of the state's actions; a label that comes late takes the place of the silence."""
        if not label:
            self._silent.add(turn)
        elif turn in self._silent:
            self._silent.remove(turn)
            self._count(turn, 0.0, -1)
        self._count(turn, label, 1)

    def _count(self, turn: int, label: float, times: int) -> None:
        """Multiply the likelihoods by those of a label, or divide them with `times=-1`."""
        (state, *_), action = self.steps[turn - 1]
        event = int(np.sign(label)) + 1
        row = self._heard.setdefault(state, np.zeros((self.actions, self._log.shape[2])))
        row += times * self._log[0, event]
        row[action] += times * (self._log[1, event] - self._log[0, event])

    def weights(self) -> NDArray[np.float64]:
        """The posterior of the strategies, shape (strategies,); given a strategy, states are independent."""
        log = sum((np.logaddexp.reduce(row, axis=0) for row in self._heard.values()), np.zeros(self._log.shape[2]))
        weights = np.exp(log - log.max())
        return np.asarray(weights / weights.sum())

    def choose(self, here: Features) -> int:
        """The action that is most probably the best."""
        row = self._heard.get(here[0])
        if row is None:
            return int(self.rng.integers(self.actions))
        chances = np.exp(row - np.logaddexp.reduce(row, axis=0)) @ self.weights()
        return self.best(chances)


@dataclass(frozen=True)
class Sabl(Evaluated):
    """Strategy-aware Bayesian learning (SABL, Loftin et al. 2014, 2016), for trainers whose silence has a meaning.

    The model: a trainer errs with probability `error`, and is silent with probability `plus` after an action that it
    finds right, with `minus` after one that it finds wrong. So the silence of a trainer that mostly blames is praise.
    With `infers` it is I-SABL, which infers `plus` and `minus` from all labels: here by their posterior on a grid of 10
    by 10, in the papers by expectation maximisation. A turn counts as one of silence until its label comes; in the
    papers a label comes before the next action, or never.
    """

    error: Annotated[float, Range(1e-6, 0.5 - 1e-6)] = 0.1
    """Probability that the trainer errs, above 0 and below 0.5."""
    plus: Share = 0.1
    """Probability of silence after a right action, 0 to 1."""
    minus: Share = 0.1
    """Probability of silence after a wrong action, 0 to 1."""
    infers: bool = False
    """Whether it infers `plus` and `minus` instead of using the given values."""
    reads = "atoms"
    policy = _Policy
    batch = "Sabls"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tiles:
            raise ValueError(f"tiles must be 0, got {self.tiles}: sabl infers each state separately")
