"""The open lessons of a server: a limited number, without those that have been idle for long."""

import re
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.episodes.live import OutOfTurnError
from llf_teacher.episodes.record import Record
from llf_teacher.studies.store import Store
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.plan import Plan
from pz_envs.seats import STUDENT, TEACHER

_CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")


class Terms(NamedTuple):
    """Limits of the server, and conditions for people in seats."""

    consent: str = ""
    """A text to which people must agree; empty: none."""
    codes: bool = False
    """Whether people give a participant's code."""
    undo: bool = True
    """Whether turns can be undone."""
    store: Path | None = None
    """The store of finished episodes with people; None: none."""
    most: int = 100
    """Greatest number of open lessons."""
    idle: float = 3600.0
    """Seconds without a request after which a lesson is closed."""
    ids: tuple[str, ...] = ()
    """Environments of Gymnasium's registry that are offered beside ours; no others are."""


@dataclass
class OpenLesson:
    """A lesson and the secrets of its seats."""

    lesson: PlannedLesson
    tokens: dict[str, str]
    """The secret of each seat, by the seat."""
    codes: dict[str, str] = field(default_factory=dict)
    """By seat the codes of the participants that have taken one."""
    seen: float = 0.0
    """The time of the last request."""
    kept: bool = False
    """Whether the episode is in the store."""
    version: int = 0
    """The number of changes."""


class FullError(ValueError):
    """There are as many lessons as allowed."""


class OpenLessons:
    """The lessons of a server, by the secrets of their seats.

    Args:
        terms: limits and conditions.
        clock: a monotonic clock, in seconds.
    """

    def __init__(self, terms: Terms, clock: Callable[[], float] = time.monotonic) -> None:
        self.terms, self._clock = terms, clock
        self._open: list[OpenLesson] = []
        self._seats: dict[str, tuple[OpenLesson, str]] = {}

    def __len__(self) -> int:
        return len(self._open)

    def begin(self, plan: Plan) -> OpenLesson:
        """A new lesson; without consent and codes, people take their seats at once.

        Raises:
            FullError: there are as many lessons as allowed.
            ValueError: the lesson cannot be played.
        """
        self.sweep()
        if len(self._open) >= self.terms.most:
            raise FullError(
                f"all {self.terms.most} lessons are in use; try again later, or start the server with more --sessions"
            )
        seats = plan.people or {plan.seat}
        opened = OpenLesson(PlannedLesson(plan), {seat: secrets.token_urlsafe(16) for seat in sorted(seats)})
        opened.seen = self._clock()
        if not (self.terms.consent or self.terms.codes):
            opened.codes = dict.fromkeys(plan.people, "")
        self._open.append(opened)
        self._seats |= {token: (opened, seat) for seat, token in opened.tokens.items()}
        return opened

    def find(self, token: str) -> tuple[OpenLesson, str]:
        """The lesson and the seat of a secret.

        Raises:
            LookupError: the secret is unknown.
        """
        self.sweep()
        opened, seat = self._seats[token]
        opened.seen = self._clock()
        return opened, seat

    def sweep(self) -> None:
        """Close the lessons without a request for `idle` seconds."""
        late = self._clock() - self.terms.idle
        for opened in [each for each in self._open if each.seen <= late]:
            self._open.remove(opened)
            for token in opened.tokens.values():
                del self._seats[token]
            opened.lesson.close()

    def sit(self, opened: OpenLesson, seat: str, agreed: Any, code: Any) -> None:
        """Give a person a seat.

        Raises:
            ValueError: the person has not agreed, or gives no code where one is needed.
        """
        if seat not in opened.lesson.plan.people or seat in opened.codes:
            return
        if self.terms.consent and agreed is not True:
            raise ValueError("to take part you must agree; otherwise no lesson begins and nothing is stored")
        if self.terms.codes and not (isinstance(code, str) and _CODE.fullmatch(code)):
            raise ValueError("the code must be 1 to 32 letters, digits, '-' or '_'; give the one that you received")
        opened.codes[seat] = code if self.terms.codes else ""
        opened.version += 1

    def move(self, opened: OpenLesson, seat: str, what: Any, turn: Any) -> None:
        """Play a turn in a seat; an episode that ends is written to the store.

        Args:
            opened: the lesson.
            seat: the seat.
            what: as of `PlannedLesson.move`.
            turn: the turn that the move is for, so that the same move does not count twice.

        Raises:
            OutOfTurnError: the lesson is at another turn, or as of `PlannedLesson.move`.
            ValueError: as of `PlannedLesson.move`, or a person has not taken its seat.
        """
        lesson = opened.lesson
        if waiting := lesson.plan.people - opened.codes.keys():
            who = "you have" if seat in waiting else f"the {NAMES[min(waiting)]} has"
            raise ValueError(f"{who} not taken a seat yet; the lesson begins when all people have")
        _check_turn(lesson, turn)
        lesson.move(seat, what)
        opened.version += 1
        if lesson.over and lesson.plan.people and self.terms.store is not None:
            with Store(self.terms.store) as store:
                store.add(_as_new_sample(self.record(opened), store))
            opened.kept = True

    def undo(self, opened: OpenLesson, seat: str, turn: Any) -> None:
        """Undo the last turn; `turn` as for `move`.

        Raises:
            OutOfTurnError: the lesson is at another turn.
            ValueError: as of `PlannedLesson.undo`, or undo is not allowed.
        """
        if not self.terms.undo:
            raise ValueError("this server does not allow to take turns back; begin a new lesson")
        if opened.kept:
            raise ValueError("the episode is in the store already; begin a new lesson")
        _check_turn(opened.lesson, turn)
        opened.lesson.undo(seat)
        opened.version += 1

    def record(self, opened: OpenLesson) -> Record:
        """The record of the episode.

        Raises:
            ValueError: the episode is not over.
        """
        return opened.lesson.record(opened.lesson.plan.spec(opened.codes))


NAMES = {STUDENT: "student", TEACHER: "teacher"}
"""The seats by the words of the page."""


def _check_turn(lesson: PlannedLesson, turn: Any) -> None:
    now = lesson.session.moment.turn
    if type(turn) is not int:
        raise ValueError(f"turn must be a whole number, the turn of the lesson's state, got {turn!r:.60}")
    if turn != now:
        raise OutOfTurnError(f"the lesson is at turn {now}, and this was sent for turn {turn}; look at its state first")


def _as_new_sample(record: Record, store: Store) -> Record:
    """The record with the next free sample number: people can play the same world again."""
    spec = record.spec
    while store.has(spec.key):
        spec = spec._replace(sample=spec.sample + 1)
    return record._replace(spec=spec)
