"""Teachers of a study beside personalities: frozen values that spec strings name.

The words of policies and models have no claims; studies count them as `unchecked`, and count the claims that a reader
finds in them.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar, NamedTuple

import numpy as np

from teachers.personality import Personality
from teachers.spec import Spec, call_string
from teachers.voice import Voice

CUT, EMPTY, REPEATS = "cut", "empty", "repeats"
"""Faults of a model's answer in the teacher's seat: it was cut at its greatest length; it holds nothing to say, as
words in place of JSON; it repeats what the student sees."""
FAULTS = {
    CUT: "cut at max_tokens",
    EMPTY: "without a claim, or words, to say",
    REPEATS: "repeating what the student sees",
}
"""The faults in words."""


class TeacherReply(NamedTuple):
    """A model's answer in the teacher's seat."""

    answer: str
    """The text without thoughts, cut at 8,192 characters."""
    finish: str
    """Why it ended; `length` if it was cut."""
    seconds: float
    """From the request to the answer, when the answer was paid for."""
    form: str
    """The form in which it was asked for: `json`, `tool` or `text`."""
    faults: tuple[str, ...] = ()
    """Some of `CUT`, `EMPTY` and `REPEATS`."""


class Speaker(Spec, ABC):
    """Base of the teachers that are not personalities."""

    package: ClassVar[str] = "llf_teacher.speakers"
    mute: ClassVar[bool] = False
    """Whether it says only the instruction."""
    own_words: ClassVar[bool] = True
    """Whether it may speak in its own words, which need a reader."""

    @abstractmethod
    def arguments(self) -> dict[str, Any]:
        """The arguments of `llf_teacher.make` for one episode."""

    def check(self, environment: Mapping[str, str]) -> None:
        """Check, before a study begins, that it can speak here; errors as in `Student.check`."""

    def facts(self) -> dict[str, Any]:
        """Entries for a study's manifest, as JSON values."""
        return {}


class Wording(Spec, ABC):
    """Puts a personality's claims into words: the last part of `mistake | voice(tone='warm')`."""

    package: ClassVar[str] = "llf_teacher.speakers"
    own_words: ClassVar[bool] = True
    """Whether the wording has its own words, which need a reader."""

    @abstractmethod
    def voice(self) -> Voice:
        """A voice for `llf_teacher.make`."""

    def check(self, environment: Mapping[str, str]) -> None:
        """See `Speaker.check`."""


@dataclass(frozen=True)
class Voiced(Speaker):
    """A personality with a voice."""

    personality: Personality
    wording: Wording

    @property
    def mute(self) -> bool:  # type: ignore[override]  # depends on the personality
        """Whether the personality is mute."""
        return self.personality.mute

    @property
    def own_words(self) -> bool:  # type: ignore[override]  # depends on the wording
        """Whether the wording has its own words."""
        return self.wording.own_words

    def __str__(self) -> str:
        return f"{self.personality} | {self.wording}"

    def arguments(self) -> dict[str, Any]:
        """The personality and the voice."""
        return {"teacher": self.personality, "voice": self.wording.voice()}

    def check(self, environment: Mapping[str, str]) -> None:
        """Check the wording."""
        self.wording.check(environment)


@dataclass(frozen=True)
class _Imported:
    """An object of a user's own module, named by a spec."""

    module: str
    factory: str
    options: tuple[tuple[str, Any], ...] = ()
    """Keyword arguments, in the given order."""

    def __str__(self) -> str:
        return call_string(f"{self.module}:{self.factory}", dict(self.options))

    def imported(self) -> Callable[..., Any]:
        """The object."""
        found: Callable[..., Any] = getattr(import_module(self.module), self.factory)
        return found


@dataclass(frozen=True)
class CustomTeacher(_Imported, Speaker):
    """A policy for the teacher's seat, with `reset(rng)` and `act(observation, info)`, also `async`, by its factory."""

    __str__ = _Imported.__str__

    def arguments(self) -> dict[str, Any]:
        """A new policy."""
        return {"teacher": self.imported()(**dict(self.options))}


@dataclass(frozen=True)
class CustomVoice(_Imported, Wording):
    """A function that rewrites a sentence, or, if it is a class or has arguments, the factory of such a function."""

    __str__ = _Imported.__str__

    def voice(self) -> Voice:
        """The function."""
        found = self.imported()
        voice: Voice = found(**dict(self.options)) if self.options or isinstance(found, type) else found
        return voice


class InstructionOnly:
    """A teacher's policy that gives the instruction and then says nothing."""

    def __init__(self, policy: Any) -> None:
        self._policy = policy

    def reset(self, rng: np.random.Generator) -> Any:
        """Reset the policy."""
        return self._policy.reset(rng)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> Any:
        """The policy's first words; afterwards the empty string."""
        return "" if info["moment"].turn else self._policy.act(observation, info)
