"""Personalities that choose kinds by numbers, so that a policy trained in the teacher's seat can teach anywhere."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from teachers.feedback import of_subset
from teachers.personality import Claims, Personality, Stage, View

__all__ = ["ChoosesKinds"]


class _Choice(Stage["ChoosesKinds"]):
    """Asks the personality in each turn."""

    def speak(self, claims: Claims, view: View) -> Claims:
        if view.numbers is None:
            raise ValueError(f"{self.spec} needs a lesson, whose turns are known; play it in an environment")
        numbers = view.numbers(view.moment, {claim.kind for claim in claims}, view.asked)
        subset = self.spec.choose(np.array(numbers, np.float32))
        return of_subset(claims, subset)


@dataclass(frozen=True)
class ChoosesKinds(Personality, ABC):
    """Passes on the claims of the kinds that `choose` returns.

    A subclass overrides `choose`. Its numbers are those that a teacher with `speech="kinds"` and
    `teacher_numbers=True` observes: `asked`, if the student can ask, then `available`, then `features`.
    """

    stage = _Choice

    @property
    def needs(self) -> frozenset[str]:
        """The oracle must tell what is at stake."""
        return frozenset(("importance",))

    @abstractmethod
    def choose(self, numbers: npt.NDArray[Any]) -> int:
        """The kinds to say, as a subset's number, 0 to 31: bit i is kind i.

        Args:
            numbers: float32 of shape (10,), or (11,) if the student can ask.
        """
