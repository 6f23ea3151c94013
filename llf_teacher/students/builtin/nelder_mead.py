"""nelder_mead: moves a simplex over a box of actions, by rewards, with or without advice.

For worlds whose state is the last action.
"""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from llf_teacher.students.learner import Learner, LearnerPolicy
from pz_envs.learning import Smooth
from teachers.spec import Share


class _Policy(LearnerPolicy["NelderMead"]):
    """The simplex, best point first, the points to try next, and the stage of the method."""

    def clear(self) -> None:
        """Start with a simplex at a random action, with edges towards the middle of the box."""
        self._low, self._high = self.action_box.low, self.action_box.high
        first = np.asarray(self.world.sample_action(self.rng), float)
        edges = self.spec.size * (self._high - self._low)
        edges = np.where(first > (self._low + self._high) / 2, -edges, edges)
        self._simplex: list[tuple[float, np.ndarray]] = []
        self._stage = "build"
        self._next = [first, *(first + np.diag(edges))]

    def choose(self, wrong: Collection[Any] = ()) -> np.ndarray:
        """The next point to try; warnings are ignored."""
        self._own = np.asarray(np.clip(self._next[0], self._low, self._high), self._low.dtype)
        return self._own

    def take(self, action: Any) -> None:
        """Note the tried point."""
        self._trial = np.asarray(action, self._low.dtype)
        self._by_advice = action is not self._own

    def learn(self, reward: float, over: bool) -> None:
        """Continue the method with the reward of the last point."""
        if not self._by_advice or self._stage in ("build", "shrink"):
            del self._next[0]
            self._judge(reward, self._trial)
        elif reward > self._simplex[-1][0]:
            self._replace((reward, self._trial))

    def _judge(self, reward: float, trial: np.ndarray) -> None:
        """One step of the method; while points wait to be tried, only note the reward."""
        simplex, tried = self._simplex, (reward, trial)
        if self._stage in ("build", "shrink"):
            simplex.append(tried)
            if not self._next:
                self._reflect()
        elif self._stage == "reflect":
            if reward > simplex[0][0]:
                self._reflected = tried
                self._try("expand", 2.0)
            elif reward > simplex[-2][0]:
                self._replace(tried)
            elif reward > simplex[-1][0]:
                self._reflected = tried
                self._try("contract", 0.5)
            else:
                self._reflected = simplex[-1]
                self._try("contract", -0.5)
        elif self._stage == "expand":
            self._replace(max(tried, self._reflected, key=_reward))
        elif reward > self._reflected[0]:
            self._replace(tried)
        else:
            best = simplex[0][1]
            self._stage, self._next = "shrink", [(best + point) / 2 for _, point in simplex[1:]]
            del simplex[1:]

    def _replace(self, vertex: tuple[float, np.ndarray]) -> None:
        self._simplex[-1] = vertex
        self._reflect()

    def _reflect(self) -> None:
        self._simplex.sort(key=_reward, reverse=True)
        self._try("reflect", 1.0)

    def _try(self, stage: str, factor: float) -> None:
        """Try a point on the line from the worst vertex through the centre of the others.

        Args:
            stage: the next stage.
            factor: distance from the centre, in distances of the worst vertex; negative on the side of that vertex.
        """
        centre = np.mean([point for _, point in self._simplex[:-1]], axis=0)
        self._stage, self._next = stage, [centre + factor * (centre - self._simplex[-1][1])]


@dataclass(frozen=True)
class NelderMead(Learner):
    """Nelder & Mead 1965, one point of the simplex per turn; points outside the box are moved to its edge.

    An advised point joins the first simplex; later it replaces the worst point if it is better.
    """

    size: Share = 0.2
    """Edge of the first simplex, as a fraction of the box's width, 0 to 1."""
    suits = Smooth
    policy = _Policy


def _reward(vertex: tuple[float, np.ndarray]) -> float:
    return vertex[0]
