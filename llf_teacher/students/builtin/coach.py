"""coach: a policy whose actions become likelier by praise and rarer by blame, as an actor learns from its critic."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.evaluated import (
    Evaluated,
    EvaluatedPolicy,
    Features,
    Table,
    check_shares,
    softmax,
    stated_reward,
)
from teachers.spec import check_range

_LISTENS = ("verdicts", "rewards")


class _Policy(EvaluatedPolicy["Coach"]):
    """Preferences per state; probabilities are their softmax."""

    def clear(self) -> None:
        """Prefer nothing."""
        self._preference = Table(self.actions)
        self._pending: list[tuple[Features, Any]] = []

    def begin(self) -> None:
        """Have an empty trace."""
        super().begin()
        self._trace: list[tuple[Features, np.ndarray]] = []
        """Gradients of the log-probabilities of what was done, the latest last."""

    def label(self, claim: Any, action: int) -> float | None:
        """A verdict, or the reward that is told."""
        return stated_reward(claim) if self.spec.listens == "rewards" else super().label(claim, action)

    def hear(self, state: Features, action: int, label: float) -> None:
        """The score of the action joins the trace, and the trace is moved by the label."""
        spec = self.spec
        gradient = -softmax(self._preference(state))
        gradient[action] += 1.0
        self._trace.append((state, gradient))
        if not label:
            return
        weight, fading = spec.alpha * label, 1.0 if spec.episodic else spec.trace
        for past, change in reversed(self._trace):
            self._move(past, weight * change)
            weight *= fading
            if not weight:
                break

    def _move(self, state: Features, change: np.ndarray) -> None:
        if self.spec.episodic:
            self._pending.append((state, change * self.spec.gamma ** (len(self.lived) - 1)))
        else:
            self._preference.add(state, change)

    def end(self) -> None:
        """What was learned in an episode counts from the next on, if it is learned by episodes."""
        for state, change in self._pending:
            self._preference.add(state, change)
        self._pending = []

    def choose(self, here: Features) -> int:
        """A draw."""
        return int(self.rng.choice(self.actions, p=softmax(self._preference(here))))


@dataclass(frozen=True)
class Coach(Evaluated):
    """COACH (MacGlashan et al. 2017): the label stands for the advantage of the action in a policy gradient.

    With `episodic` it is E-COACH (Shah et al. 2021), which converges whether a trainer judges by a policy, by rewards
    or by advantages: within an episode the policy stays, the trace is whole, and what is heard later counts less, by
    `gamma` a turn. It learns when an episode ends, so in lifetimes only.
    """

    alpha: float = 0.5
    """Step size, above 0."""
    trace: float = 0.0
    """Share of the trace that is left after a turn, 0 to 1; by episodes all of it is."""
    listens: str = "verdicts"
    """What a label is: `verdicts`, 1 and -1, or `rewards`, the number that the teacher tells (r)."""
    episodic: bool = False
    """Whether it learns by episodes."""
    gamma: float = 0.95
    """Weight of a label against that of the turn before, 0 to 1; read by episodes only."""
    reads = "atoms"
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("alpha", self.alpha, 1e-9, math.inf)
        check_shares(self, "trace", "gamma")
        if self.listens not in _LISTENS:
            raise ValueError(f"listens must be one of {', '.join(_LISTENS)}, got {self.listens!r}")
        if not isinstance(self.episodic, bool):
            raise ValueError(f"episodic must be True or False, got {self.episodic!r}")
