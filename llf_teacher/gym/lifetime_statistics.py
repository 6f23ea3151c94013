"""A student's lifetime: statistics of its episodes for the teacher's observation."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from llf_teacher.students.student import frozen
from pz_envs.student_view import StudentView
from teachers.atoms import FP, HN, HP, ActionClaim, Moment, ParseFailure
from teachers.oracle import Oracle, RefusalError
from teachers.session import Session

EPISODE_RATE, TURN_RATE = 0.2, 0.1
"""Weight of the latest episode and of the latest turn in the moving averages."""
HALF = 4
"""The number n of visits at which n / (n + HALF) is 0.5."""
NEAR = 1e-9
"""Differences of values below this are rounding."""

FIELDS = (
    "episode",  # episodes that are over / episodes
    "success",  # moving average of the success of episodes, weight 0.2; 0 before the first has ended
    "optimal",  # 1 if the last action was optimal, else 0; 0 at the opening
    "skill",  # moving average of `optimal` over all turns, weight 0.1; 0 at first
    "visits",  # n / (n + 4) for n earlier visits of the student's state in this lifetime
    "advised",  # n / (n + 4) for n of these visits with advice for the next action
    "announced",  # 1 if the student has announced its next action, else 0
    "mistake",  # 1 if the announced action is a mistake, else 0; see `is_mistake`
    "way",  # n / (n + 4) for n turns of the oracle's plan from here, at most max_turns; 0 without one
)
"""The numbers of `lifetime`, each from 0 to 1."""


class LifetimeStatistics:
    """Statistics of a student's lifetime.

    Args:
        view: the student's seat.
        episodes: number of episodes in the lifetime.
    """

    def __init__(self, view: StudentView, episodes: int) -> None:
        self._view, self._session, self.episodes = view, view.session, episodes
        self.episode = 0
        """Episodes that are over."""
        self._success = self._optimal = self._skill = 0.0
        self._visits: dict[Any, int] = {}
        self._advised: dict[Any, int] = {}
        self._state: Any = None

    def restore(
        self, episode: int, averages: tuple[float, float, float], counts: Mapping[Any, tuple[int, int]]
    ) -> None:
        """Load the statistics of a lifetime from elsewhere, whose student is in the session.

        Args:
            episode: episodes that are over.
            averages: the features `success`, `optimal` and `skill`.
            counts: per state the numbers of visits and of visits with advice, without the current visit.
        """
        self.episode = episode
        self._success, self._optimal, self._skill = averages
        self._visits = {state: visits for state, (visits, _) in counts.items()}
        self._advised = {state: advised for state, (_, advised) in counts.items()}
        self._state = frozen(self._view.state())

    def arrive(self) -> None:
        """Count the student's current state, at the opening or after an action."""
        if self._state is not None:
            self._visits[self._state] = self._visits.get(self._state, 0) + 1
        self._state = frozen(self._view.state())

    def said(self) -> None:
        """Count the teacher's claims."""
        said = getattr(self._session.feedback, "atoms", ())
        if any(atom.kind == FP for atom in said):
            self._advised[self._state] = self._advised.get(self._state, 0) + 1

    def acted(self) -> None:
        """Count the student's action."""
        self._optimal = float(optimal(self._session.teacher.oracle, self._session.moment))
        self._skill += TURN_RATE * (self._optimal - self._skill)

    def end_episode(self) -> None:
        """Count the end of an episode."""
        self.episode += 1
        self._success += EPISODE_RATE * (self._session.moment.success - self._success)
        self._optimal = 0.0

    def features(self, announced: Any = None) -> np.ndarray:
        """The numbers of `FIELDS`, float32 of shape (9,)."""
        visits, advised = self._visits.get(self._state, 0), self._advised.get(self._state, 0)
        mistake = announced is not None and is_mistake(self._session, announced)
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
    """The space of `LifetimeStatistics.features`."""
    return spaces.Box(0, 1, (len(FIELDS),), np.float32)


def optimal(oracle: Oracle, moment: Moment[Any]) -> bool:
    """Whether the action of a moment has no regret; False where the oracle has no regret."""
    try:
        return oracle.regret(moment) <= NEAR
    except RefusalError:
        return False


def is_mistake(session: Session, action: Any) -> bool:
    """Whether an action of the session's student would be a mistake now.

    If actions have values, a mistake is worth less than another action. Otherwise the oracle tries the action, and it
    is a mistake if the oracle blames it; without verdicts on actions, any hn claim counts.

    Raises:
        ValueError: the action is outside the action space.
    """
    if type(action) is ParseFailure or type(action := session.read(action)) is ParseFailure:
        return True
    oracle, moment = session.teacher.oracle, session.moment
    values = oracle.values(moment.after)
    if values is not None:
        return bool(values[action] < max(values) - NEAR)
    if HN not in oracle.feedback_types:
        return False
    found = oracle.judge(oracle.try_out(moment, action), {HP, HN})
    verdicts = [claim for claim in found if isinstance(claim, ActionClaim)] or found
    return any(claim.kind is HN for claim in verdicts)
