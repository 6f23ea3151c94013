"""Scripted policies for the teachers' seats: they say all available kinds, or the suggestion."""

from collections.abc import Callable
from typing import Any

import numpy as np

from teachers.atoms import Utterance
from teachers.feedback import SUBSETS
from teachers.spec import unknown


class SayAll:
    """A policy for a `TutoringEnv` or a `PanelEnv` that says all available kinds."""

    def __repr__(self) -> str:
        return "SayAll()"

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """All available kinds."""
        return subset_of(observation["available"])


class SaySuggestion:
    """A policy for a `TutoringEnv` or a `PanelEnv` with `speech="message"` that says the suggestion."""

    def __repr__(self) -> str:
        return "SaySuggestion()"

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Utterance:
        """The suggestion."""
        said: Utterance = info["suggestion"]
        return said


class Attention:
    """A policy for a `ClassroomEnv` that divides its attention among the students by a rule.

    Args:
        rule: `round_robin`, the student that has waited longest; `importance`, the student with the most important next
            action; `random`. Ties go to the lower number. Students without available kinds are skipped.

    Raises:
        ValueError: the rule is unknown.
    """

    def __init__(self, rule: str = "round_robin") -> None:
        if rule not in RULES:
            raise ValueError(unknown("rule", rule, RULES))
        self._rank = RULES[rule]
        self.rule = rule

    def __repr__(self) -> str:
        return f"Attention({self.rule!r})"

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""
        self.rng = rng
        self._clock = 0
        self._heard: dict[int, int] = {}

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> int:
        """Say all available kinds to the student that ranks first by the rule; 0 if there is nothing to say."""
        per_student = (observation["action_mask"][1:].reshape(len(observation["students"]), -1)).any(axis=1)
        waiting = np.flatnonzero(per_student).tolist()
        if not waiting:
            return 0
        self._clock += 1
        student = max(waiting, key=lambda i: (self._rank(self, observation, i), -i))
        self._heard[student] = self._clock
        chosen: int = (SUBSETS - 1) * student + subset_of(observation["available"][student])
        return chosen  # as in ClassroomEnv.address

    def _waited(self, observation: dict[str, Any], student: int) -> float:
        return -self._heard.get(student, 0)

    def _importance(self, observation: dict[str, Any], student: int) -> float:
        return float(observation["students"][student, 2])

    def _chance(self, observation: dict[str, Any], student: int) -> float:
        return self.rng.random()


def refuse_unread(speech: str, teacher_numbers: bool) -> None:
    """Check the settings of scripted teachers, which read the Dict of `speech="kinds"`.

    Raises:
        ValueError: the speech is not `kinds`, or teachers would observe one array.
    """
    if teacher_numbers:
        raise ValueError(
            "teacher_numbers=True is not used in this parallel form, whose teachers are scripted; leave it out, or "
            "take the AEC form"
        )
    if speech in ("message", "claims"):
        raise ValueError(
            f"speech {speech!r} has no parallel form, whose teachers are scripted; allowed: kinds; for others take the "
            "AEC form, as it is or with policies of your own in pz_envs.parallel_seats.ParallelSeats"
        )


def subset_of(bits: np.ndarray) -> int:
    """The number of the subset of the kinds whose bits are 1."""
    return sum(1 << kind for kind, bit in enumerate(bits.tolist()) if bit)


RULES: dict[str, Callable[[Attention, dict[str, Any], int], float]] = {
    "round_robin": Attention._waited,
    "importance": Attention._importance,
    "random": Attention._chance,
}
"""Per rule the rank of a student; the greatest comes first."""
