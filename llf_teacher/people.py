"""People in seats, as studies name them: who sat there in the browser.

`llf_teacher.people:PersonLearning(code='p07')` is a student, `llf_teacher.people:PersonTeaching(code='p07')` a teacher.
No program can play them: `llf serve --store` writes their episodes, which studies and reports read like all others.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NoReturn

import numpy as np

from pz_envs.settings import SPEECHES
from teachers.personality import Claims, Personality, Stage, View, parse_personality

__all__ = ["PersonLearning", "PersonTeaching"]

_ABSENT = "sits at a page in the browser, where no program can stand in; `llf serve --store` writes such episodes"


class _Stage(Stage["PersonTeaching"]):
    """Cannot speak here."""

    def speak(self, claims: Claims, view: View) -> Claims:
        raise ValueError(f"{self.spec} {_ABSENT}")


@dataclass(frozen=True)
class PersonTeaching(Personality):
    """A person in the teacher's seat.

    Raises:
        ValueError: there is no such speech or personality.
    """

    code: str = ""
    """The participant's code; empty if there are none."""
    speech: str = "claims"
    """How it spoke: `claims`, chosen among those that there were to say, or `message`, words of its own."""
    offers: str = "oracle"
    """The personality that said which claims there were, or made suggestions."""

    source = "a person"
    honest = False
    stage = _Stage

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speech not in SPEECHES:
            raise ValueError(f"speech {self.speech!r} is unknown; allowed: {', '.join(SPEECHES)}")
        object.__setattr__(self, "offers", str(parse_personality(self.offers)))


class PersonLearning:
    """A person in the student's seat, by the protocol of agents.

    Args:
        code: the participant's; empty if there are none.
    """

    reads: ClassVar[str] = "words"
    text = True

    def __init__(self, code: str = "") -> None:
        self.code = code

    def reset(self, rng: np.random.Generator) -> NoReturn:
        """Refuse to play.

        Raises:
            ValueError: always.
        """
        raise ValueError(f"the student of code {self.code!r} {_ABSENT}")

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> NoReturn:
        """As `reset`."""
        raise ValueError(f"the student of code {self.code!r} {_ABSENT}")
