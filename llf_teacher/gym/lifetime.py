"""A student's lifetime: many episodes in a row, of which a teacher sees more than the present moment."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from llf_teacher.students.student import Student, frozen
from pz_envs.student_view import StudentView
from teachers.atoms import FP, Moment
from teachers.oracle import Oracle, RefusalError
from teachers.spec import unknown

EPISODE_RATE, TURN_RATE = 0.2, 0.1
"""Weight of the latest episode and of the latest turn in the moving averages."""
HALF = 4
"""So many visits of a state count as half of what can be."""
NEAR = 1e-9
"""Regret below this is rounding."""

FIELDS = (
    "episode",  # episodes that are over / episodes
    "success",  # moving average of the success of episodes, weight 0.2; 0 before the first has ended
    "optimal",  # 1 if the last action was optimal, else 0; 0 at the opening
    "skill",  # moving average of that over all turns, weight 0.1; 0 at first
    "visits",  # n / (n + 4) for n earlier visits of the student's state in this lifetime
    "advised",  # n / (n + 4) for n of these visits in which advice for the next action was said
    "announced",  # 1 if the student has announced its next action, else 0
    "mistake",  # 1 if what it announced is a mistake, else 0; see `Session.mistake`
    "way",  # n / (n + 4) for n turns of the oracle's plan from here, at most max_turns; 0 without one
)
"""The numbers of `lifetime`, each from 0 to 1."""


class Lifetime:
    """What a teacher remembers of a student.

    Args:
        view: the student's seat.
        episodes: episodes of the lifetime.
    """

    def __init__(self, view: StudentView, episodes: int) -> None:
        self._view, self._session, self.episodes = view, view.session, episodes
        self.episode = 0
        """Episodes that are over."""
        self._success = self._optimal = self._skill = 0.0
        self._visits: dict[Any, int] = {}
        self._advised: dict[Any, int] = {}
        self._state: Any = None

    def recall(self, episode: int, averages: tuple[float, float, float], counts: Mapping[Any, tuple[int, int]]) -> None:
        """Have seen so much of a lifetime that was played elsewhere; the student is where the seats have it.

        Args:
            episode: episodes that are over.
            averages: the features `success`, `optimal` and `skill`.
            counts: per state, how often it was visited and how often advised; without the present visit.
        """
        self.episode = episode
        self._success, self._optimal, self._skill = averages
        self._visits = {state: visits for state, (visits, _) in counts.items()}
        self._advised = {state: advised for state, (_, advised) in counts.items()}
        self._state = frozen(self._view.state())

    def arrive(self) -> None:
        """Take note of the state that the student is in now, at the opening or after an action."""
        if self._state is not None:
            self._visits[self._state] = self._visits.get(self._state, 0) + 1
        self._state = frozen(self._view.state())

    def said(self) -> None:
        """Take note of what the teacher has said."""
        said = getattr(self._session.feedback, "atoms", ())
        if any(atom.kind == FP for atom in said):
            self._advised[self._state] = self._advised.get(self._state, 0) + 1

    def acted(self) -> None:
        """Take note of the student's action."""
        self._optimal = float(optimal(self._session.teacher.oracle, self._session.moment))
        self._skill += TURN_RATE * (self._optimal - self._skill)

    def over(self) -> None:
        """Take note of the end of an episode."""
        self.episode += 1
        self._success += EPISODE_RATE * (self._session.moment.success - self._success)
        self._optimal = 0.0

    def features(self, announced: Any = None) -> np.ndarray:
        """The numbers of `FIELDS`, float32 of shape (9,)."""
        visits, advised = self._visits.get(self._state, 0), self._advised.get(self._state, 0)
        mistake = announced is not None and self._session.mistake(announced)
        moment = self._session.moment
        way = () if moment.over else self._session.teacher.oracle.plan(moment.after, self._session.max_turns)
        return np.array(
            (
                self.episode / self.episodes,
                self._success,
                self._optimal,
                self._skill,
                visits / (visits + HALF),
                advised / (advised + HALF),
                announced is not None,
                mistake,
                len(way) / (len(way) + HALF),
            ),
            np.float32,
        )


def lifetime_space() -> spaces.Box:
    """The space of `Lifetime.features`."""
    return spaces.Box(0, 1, (len(FIELDS),), np.float32)


def optimal(oracle: Oracle, moment: Moment[Any]) -> bool:
    """Whether the action of a moment lost nothing; False where the oracle does not know."""
    try:
        return oracle.regret(moment) <= NEAR
    except RefusalError:
        return False


def drawn(student: Student, vary: Mapping[str, Any], rng: np.random.Generator) -> Student:
    """A student with parameters drawn uniformly.

    Args:
        student: gives the other parameters.
        vary: per parameter its least and greatest value; of two integers an integer is drawn, both ends included.
        rng: is drawn from once per parameter, in the order of their names.
    """
    values = {}
    for name in sorted(vary):
        low, high = vary[name]
        values[name] = int(rng.integers(low, high + 1)) if is_whole(low, high) else float(rng.uniform(low, high))
    return dataclasses.replace(student, **values)


def is_whole(low: Any, high: Any) -> bool:
    """Whether an integer is drawn between these ends."""
    return isinstance(low, int) and isinstance(high, int)


def check_vary(student: Any, vary: Mapping[str, Any]) -> None:
    """Make sure that students can be drawn.

    Raises:
        ValueError: it has no such parameter, a range is none, or an end of it is not allowed.
    """
    if not isinstance(student, Student):
        raise ValueError(f"vary needs a student given by its spec, got {student!r}")
    names = [field.name for field in dataclasses.fields(student)]
    for name, ends in vary.items():
        if name not in names:
            raise ValueError(unknown(f"parameter of {student.name}", name, names))
        numbers = isinstance(ends, tuple | list) and all(type(end) in (int, float) for end in ends)
        if not numbers or len(ends) != 2 or ends[0] > ends[1]:
            raise ValueError(f"vary[{name!r}] must be the least and the greatest value, got {ends!r}")
        for end in ends:
            dataclasses.replace(student, **{name: end})
