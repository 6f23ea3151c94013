"""The open lessons of a page, by the addresses of their seats."""

import secrets
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from llf_teacher.episodes.live import OutOfTurnError
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.plan import Plan
from pz_envs.seats import STUDENT, TEACHER

MOST = 20
"""Greatest number of open lessons."""
NAMES = {STUDENT: "student", TEACHER: "teacher"}
"""The seats by the words of the page."""


@dataclass
class OpenLesson:
    """A lesson and the addresses of its seats."""

    lesson: PlannedLesson
    tokens: dict[str, str]
    """For each seat, the last part of its address."""
    version: int = 0
    """The number of changes."""
    film: "Future[bytes] | None" = None
    """The film of the episode, once it was requested."""

    def forget_film(self) -> None:
        """Give up a film, finished or not."""
        if self.film is not None:
            self.film.cancel()
            self.film = None


class OpenLessons:
    """The lessons of a page. If there are more than `MOST`, the lesson with the oldest last request is closed."""

    def __init__(self) -> None:
        self._open: list[OpenLesson] = []  # the first lesson has the oldest last request
        self._seats: dict[str, tuple[OpenLesson, str]] = {}

    def __len__(self) -> int:
        return len(self._open)

    def begin(self, plan: Plan) -> OpenLesson:
        """A new lesson.

        Raises:
            ValueError: the lesson cannot be played.
        """
        seats = plan.people or {plan.seat}
        opened = OpenLesson(PlannedLesson(plan), {seat: secrets.token_urlsafe(16) for seat in sorted(seats)})
        self._open.append(opened)
        self._seats |= {token: (opened, seat) for seat, token in opened.tokens.items()}
        if len(self._open) > MOST:
            self._close(self._open[0])
        return opened

    def _close(self, opened: OpenLesson) -> None:
        self._open.remove(opened)
        for token in opened.tokens.values():
            del self._seats[token]
        opened.forget_film()
        opened.lesson.close()

    def find(self, token: str) -> tuple[OpenLesson, str]:
        """The lesson and the seat of an address.

        Raises:
            LookupError: there is none.
        """
        opened, seat = self._seats[token]
        self._open.remove(opened)
        self._open.append(opened)
        return opened, seat

    def move(self, opened: OpenLesson, seat: str, what: Any, turn: Any) -> None:
        """Play a turn in a seat.

        Args:
            opened: the lesson.
            seat: the seat.
            what: as in `PlannedLesson.move`.
            turn: the turn of the move, so that a repeated request does not count twice.

        Raises:
            OutOfTurnError: the lesson is at another turn, or as in `PlannedLesson.move`.
            ValueError: as in `PlannedLesson.move`.
        """
        _check_turn(opened.lesson, turn)
        opened.lesson.move(seat, what)
        opened.version += 1

    def undo(self, opened: OpenLesson, seat: str, turn: Any) -> None:
        """Take back the last turn; `turn` as in `move`.

        Raises:
            OutOfTurnError: the lesson is at another turn.
            ValueError: as in `PlannedLesson.undo`.
        """
        _check_turn(opened.lesson, turn)
        opened.lesson.undo(seat)
        opened.forget_film()
        opened.version += 1


def _check_turn(lesson: PlannedLesson, turn: Any) -> None:
    now = lesson.session.moment.turn
    if type(turn) is not int:
        raise ValueError(f"turn must be a whole number, the turn of the episode's state, got {turn!r:.60}")
    if turn != now:
        raise OutOfTurnError(
            f"the episode is at turn {now}, and this was sent for turn {turn}; look at its state first"
        )
