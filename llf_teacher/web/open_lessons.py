"""The lessons that a server holds: not too many, and none that nobody plays any more."""

import re
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from llf_teacher.episodes.record import Record
from llf_teacher.studies.store import Store
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.plan import Plan
from pz_envs.seats import STUDENT, TEACHER

_CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")


class Terms(NamedTuple):
    """What holds for everybody who sits down."""

    consent: str = ""
    """A text that people have to agree to; empty: there is none."""
    codes: bool = False
    """Whether people give a participant's code."""
    undo: bool = True
    """Whether turns can be taken back."""
    store: Path | None = None
    """Where episodes with people are written as they end; None: nowhere."""
    most: int = 100
    """Lessons at a time."""
    idle: float = 3600.0
    """Seconds after which a lesson is dropped that nobody has looked at."""


@dataclass
class OpenLesson:
    """A lesson, and who may sit where in it."""

    lesson: PlannedLesson
    tokens: dict[str, str]
    """The secret of each seat, by the seat."""
    codes: dict[str, str] = field(default_factory=dict)
    """The participants' codes, of those who have sat down."""
    seen: float = 0.0
    """When it was last looked at."""
    kept: bool = False
    """Whether the episode is in the store."""
    version: int = 0
    """How often something has changed."""


class FullError(ValueError):
    """There is no place for another lesson."""


class OpenLessons:
    """The lessons of a server, each found by the secrets of its seats.

    Args:
        terms: how many, how long, and what people have to agree to.
        clock: seconds of a clock that never goes back.
    """

    def __init__(self, terms: Terms, clock: Callable[[], float] = time.monotonic) -> None:
        self.terms, self._clock = terms, clock
        self._open: list[OpenLesson] = []
        self._seats: dict[str, tuple[OpenLesson, str]] = {}

    def __len__(self) -> int:
        return len(self._open)

    def begin(self, plan: Plan) -> OpenLesson:
        """A new lesson; without consent and codes, people sit in their seats at once.

        Raises:
            FullError: there are as many as may be.
            ValueError: the lesson cannot be played.
        """
        self.sweep()
        if len(self._open) >= self.terms.most:
            raise FullError(
                f"all {self.terms.most} places are taken; try again later, or start the server with more --sessions"
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
        """The lesson and the seat that a secret is for.

        Raises:
            LookupError: there is none.
        """
        self.sweep()
        opened, seat = self._seats[token]
        opened.seen = self._clock()
        return opened, seat

    def sweep(self) -> None:
        """Drop the lessons that nobody has looked at for long."""
        late = self._clock() - self.terms.idle
        for opened in [each for each in self._open if each.seen <= late]:
            self._open.remove(opened)
            for token in opened.tokens.values():
                del self._seats[token]
            opened.lesson.close()

    def sit(self, opened: OpenLesson, seat: str, agreed: Any, code: Any) -> None:
        """Let a person sit down.

        Raises:
            ValueError: it has not agreed, or gives no code where one is needed.
        """
        if seat not in opened.lesson.plan.people or seat in opened.codes:
            return
        if self.terms.consent and agreed is not True:
            raise ValueError("to take part you have to agree; without that nothing begins, and nothing is kept")
        if self.terms.codes and not (isinstance(code, str) and _CODE.fullmatch(code)):
            raise ValueError("give the code that you were given: 1 to 32 letters, digits, '-' or '_'")
        opened.codes[seat] = code if self.terms.codes else ""
        opened.version += 1

    def move(self, opened: OpenLesson, seat: str, what: Any) -> None:
        """One turn in a seat; an episode that ends is written to the store.

        Raises:
            ValueError: as of `PlannedLesson.move`, or the person has not sat down.
        """
        lesson = opened.lesson
        if waiting := lesson.plan.people - opened.codes.keys():
            who = "you have" if seat in waiting else f"the {NAMES[min(waiting)]} has"
            raise ValueError(f"{who} not sat down yet; the lesson begins when all people have")
        lesson.move(seat, what)
        opened.version += 1
        if lesson.over and lesson.plan.people and self.terms.store is not None:
            with Store(self.terms.store) as store:
                store.add(_unlike(self.record(opened), store))
            opened.kept = True

    def undo(self, opened: OpenLesson, seat: str) -> None:
        """Take the last turn back.

        Raises:
            ValueError: as of `PlannedLesson.undo`, or it may not be.
        """
        if not self.terms.undo:
            raise ValueError("turns cannot be taken back here")
        if opened.kept:
            raise ValueError("the episode is in the study already; begin a new lesson")
        opened.lesson.undo(seat)
        opened.version += 1

    def record(self, opened: OpenLesson) -> Record:
        """The episode as a store keeps it.

        Raises:
            ValueError: it is not over.
        """
        return opened.lesson.record(opened.lesson.plan.spec(opened.codes))


NAMES = {STUDENT: "student", TEACHER: "teacher"}
"""The seats in words."""


def _unlike(record: Record, store: Store) -> Record:
    """The record as one more sample where the store has one of that name: people may play the same world again."""
    spec = record.spec
    while store.has(spec.key):
        spec = spec._replace(sample=spec.sample + 1)
    return record._replace(spec=spec)
