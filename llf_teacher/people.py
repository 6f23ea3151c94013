"""Specs of people in the seats of episodes from the browser.

`llf_teacher.people:PersonLearning` is a student, `llf_teacher.people:PersonTeaching` a teacher. No program can play
them. The page of `llf serve` exports their episodes as stores, which reports read like all others.
"""

from dataclasses import dataclass
from typing import Any, ClassVar, NoReturn

import numpy as np

from pz_envs.settings import SPEECHES
from teachers.personality import Claims, Personality, Stage, View, parse_personality

__all__ = ["PersonLearning", "PersonTeaching"]

_ABSENT = "is a person, whom no program can play; play such episodes on the page of `llf serve`"


class _Stage(Stage["PersonTeaching"]):
    """Refuses to speak."""

    def speak(self, claims: Claims, view: View) -> Claims:
        raise ValueError(f"{self.spec} {_ABSENT}")


@dataclass(frozen=True)
class PersonTeaching(Personality):
    """A person in the teacher's seat.

    Raises:
        ValueError: an unknown speech or personality.
    """

    speech: str = "claims"
    """The form of speech: `claims`, chosen from a list, or `message`, free text."""
    offers: str = "oracle"
    """The personality whose claims or suggestions the person saw."""

    source = "a person"
    honest = False
    stage = _Stage

    @property
    def own_words(self) -> bool:
        """Whether the person speaks in words of its own."""
        return self.speech == "message"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.speech not in SPEECHES:
            raise ValueError(f"speech {self.speech!r} is unknown; allowed: {', '.join(SPEECHES)}")
        object.__setattr__(self, "offers", str(parse_personality(self.offers)))


class PersonLearning:
    """A person in the student's seat, with the interface of agents."""

    reads: ClassVar[str] = "words"
    text = True

    def reset(self, rng: np.random.Generator) -> NoReturn:
        """Refuse to play.

        Raises:
            ValueError: always.
        """
        raise ValueError(f"the student {_ABSENT}")

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> NoReturn:
        """Refuse to play.

        Raises:
            ValueError: always.
        """
        raise ValueError(f"the student {_ABSENT}")
