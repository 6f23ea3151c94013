"""What can stand for a teacher in a study beside personalities, as frozen values that texts name.

What policies and models say has no claims: nothing vouches for it, and it is counted as `unchecked`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from teachers.personality import Personality
from teachers.spec import Spec
from teachers.voice import Voice


class Speaker(Spec, ABC):
    """Base of all of them."""

    shelf: ClassVar[str] = "llf_teacher.speakers"
    mute: ClassVar[bool] = False
    """Whether it never says anything but the instruction."""

    @abstractmethod
    def arguments(self) -> dict[str, Any]:
        """What `llf_teacher.make` is told of it, made anew for an episode."""

    def check(self, environment: Mapping[str, str]) -> None:
        """Make sure, before a study begins, that it can speak here; errors as of students."""

    def facts(self) -> dict[str, Any]:
        """What a study's manifest has to say of it beside its spec, as JSON values."""
        return {}


class Wording(Spec, ABC):
    """What says a personality's claims in its own way: the last stage of `mistake | voice(tone='warm')`."""

    shelf: ClassVar[str] = "llf_teacher.speakers"

    @abstractmethod
    def voice(self) -> Voice:
        """A voice, as `llf_teacher.make` takes it."""

    def check(self, environment: Mapping[str, str]) -> None:
        """As of `Speaker`."""


@dataclass(frozen=True)
class Voiced(Speaker):
    """A personality with a voice."""

    personality: Personality
    wording: Wording

    @property
    def mute(self) -> bool:  # type: ignore[override]  # as its personality is
        """Whether the personality is."""
        return self.personality.mute

    def __str__(self) -> str:
        return f"{self.personality} | {self.wording}"

    def arguments(self) -> dict[str, Any]:
        """Both."""
        return {"teacher": self.personality, "voice": self.wording.voice()}

    def check(self, environment: Mapping[str, str]) -> None:
        """As the voice says."""
        self.wording.check(environment)


@dataclass(frozen=True)
class _Found:
    """Something of a module of the user's own, as a spec names it."""

    module: str
    factory: str
    options: tuple[tuple[str, Any], ...] = ()
    """Keyword arguments, in the order in which they were given."""

    def __str__(self) -> str:
        options = ", ".join(f"{name}={value!r}" for name, value in self.options)
        return f"{self.module}:{self.factory}({options})" if options else f"{self.module}:{self.factory}"

    def found(self) -> Callable[..., Any]:
        """What the module has under the name."""
        made: Callable[..., Any] = getattr(import_module(self.module), self.factory)
        return made


@dataclass(frozen=True)
class OwnTeacher(_Found, Speaker):
    """A policy for the teacher's seat, `reset(rng)` and `act(observation, info)`, by the factory that makes it."""

    __str__ = _Found.__str__

    def arguments(self) -> dict[str, Any]:
        """A new policy."""
        return {"teacher": self.found()(**dict(self.options))}


@dataclass(frozen=True)
class OwnVoice(_Found, Wording):
    """A function of a sentence that rewrites it; a class, or a name with arguments, makes one."""

    __str__ = _Found.__str__

    def voice(self) -> Voice:
        """The function."""
        found = self.found()
        made: Voice = found(**dict(self.options)) if self.options or isinstance(found, type) else found
        return made


class Quiet:
    """A policy of a teacher of whom nothing is wanted but the instruction."""

    def __init__(self, policy: Any) -> None:
        self._policy = policy

    def reset(self, rng: np.random.Generator) -> None:
        """Begin an episode."""
        self._policy.reset(rng)

    def act(self, observation: dict[str, Any], info: dict[str, Any]) -> str:
        """What it says first, and nothing afterwards."""
        return "" if info["moment"].turn else self._policy.act(observation, info)
