"""coach: a policy in which praise makes an action more likely and blame less likely, like an actor with a critic."""

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from llf_teacher.students.evaluated import (
    Evaluated,
    EvaluatedPolicy,
    Features,
    Table,
    softmax,
    stated_reward,
)
from teachers.spec import Range, Share

_LISTENS = ("verdicts", "rewards")


class _Policy(EvaluatedPolicy["Coach"]):
    """Preferences per state; probabilities are their softmax."""

    def clear(self) -> None:
        """Forget all preferences."""
        self._preference = Table(self.actions)
        self._pending: list[tuple[Features, Any]] = []

    def begin(self) -> None:
        """Begin an episode with an empty trace."""
        super().begin()
        self._gradients: list[np.ndarray] = []
        """Of the log-probability of each turn's action, when the turn was over."""

    def label(self, claim: Any, action: int) -> float | None:
        """A verdict, or the reward that the claim states."""
        return stated_reward(claim) if self.spec.listens == "rewards" else super().label(claim, action)

    def hear(self, turn: int, label: float) -> None:
        """Move the preferences by the label, along the trace as it was when that turn was over."""
        if turn > len(self._gradients):
            state, action = self.steps[turn - 1]
            gradient = -softmax(self._preference(state))
            gradient[action] += 1.0
            self._gradients.append(gradient)
        if not label:
            return
        spec = self.spec
        weight, fading = spec.alpha * label, 1.0 if spec.episodic else spec.trace
        if spec.episodic:
            weight *= spec.gamma ** (turn - 1)
        for past in reversed(range(turn)):
            self._move(self.steps[past][0], weight * self._gradients[past])
            weight *= fading
            if not weight:
                break

    def _move(self, state: Features, change: np.ndarray) -> None:
        if self.spec.episodic:
            self._pending.append((state, change))
        else:
            self._preference.add(state, change)

    def end(self) -> None:
        """Apply the changes of the episode, if it learns by episodes."""
        for state, change in self._pending:
            self._preference.add(state, change)
        self._pending = []

    def choose(self, here: Features) -> int:
        """A draw from the policy."""
        return int(self.rng.choice(self.actions, p=softmax(self._preference(here))))


@dataclass(frozen=True)
class Coach(Evaluated):
    """COACH (MacGlashan et al. 2017): the label replaces the advantage of the action in a policy gradient.

    A label moves the policy along an eligibility trace: the gradients of the actions up to the turn that it is about,
    each weighted by `trace` to the power of its age. With `trace=0` that turn alone counts.

    With `episodic` it is E-COACH (Shah et al. 2021), which converges for labels that depend on the policy, on rewards
    or on advantages: within an episode the policy does not change, the trace does not fade, and a label counts less by
    the factor `gamma` per turn. It learns at the end of an episode, so only in lifetimes.

    The papers assume a known delay of the trainer; here a label says which turn it is about, and moves the trace as it
    was when that turn was over. A gradient is that of the policy at that time. The policy is a softmax of a table, and
    step size and trace were chosen in houses, as the best for labels of several kinds. The robot of the first paper had
    linear functions, a trace for each button of its trainer, and many more turns.
    """

    alpha: Annotated[float, Range(1e-9, math.inf)] = 0.2
    """Step size, above 0."""
    trace: Share = 0.9
    """Share of the trace that remains after a turn, 0 to 1; unused with `episodic`."""
    listens: str = "verdicts"
    """Source of labels: `verdicts`, 1 and -1, or `rewards`, the number that the teacher states (r)."""
    episodic: bool = False
    """Whether it learns at the end of an episode."""
    gamma: Share = 0.95
    """Weight of a label relative to the turn before, 0 to 1; used with `episodic` only."""
    reads = "atoms"
    policy = _Policy

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.listens not in _LISTENS:
            raise ValueError(f"listens must be one of {', '.join(_LISTENS)}, got {self.listens!r}")
