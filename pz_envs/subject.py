"""What can be taught, and how it can be seated."""

import importlib
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, TypeGuard

from pettingzoo.utils import wrappers

from pz_envs.learning import Learning

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.seats import SeatsEnv
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase, Phrasebook
    from teachers.teacher import Teacher
    from teachers.voice import Voice
    from worlds.pictures import Picture
    from worlds.world import World

TUTORING = "tutoring"
"""The seating of one teacher and one student, which is meant where none is named."""


class Subject(ABC):
    """What can be taught: it makes worlds, and teachers and seats for them."""

    name: str
    max_turns: int
    """Turns of the student after which an episode is truncated."""
    repeated: bool
    """Whether success ends nothing: a one-step problem without state, asked again and again."""
    regret_unit: str
    """What regret counts, as in "extra moves"."""
    learning: Learning
    """What rewards alone teach."""
    visual: bool = False
    """Whether its worlds have an option `visual` that adds images to the observation."""

    @abstractmethod
    def make_world(self, **options: Any) -> "World[Any, Any, Any]":
        """A new world."""

    @abstractmethod
    def oracle_class(self) -> "Callable[[Callable[[], World[Any, Any, Any]]], Oracle]":
        """What makes an oracle of a function that makes scratch worlds."""

    @abstractmethod
    def phrasebook(self, voice: "Voice" = "plain") -> "Phrasebook":
        """The words of the teachers."""

    def options(self) -> tuple[str, ...]:
        """The names of the world's options."""
        return ()

    def taught_world(self, **options: Any) -> "World[Any, Any, Any]":
        """The world of new seats."""
        return self.make_world(**options)

    def make_picture(self, world: "World[Any, Any, Any]") -> "Picture[Any]":
        """What draws such a world; by default its description."""
        from worlds.pictures import TextPicture

        return TextPicture(world.scratch())

    def serves(self, personality: "str | Personality") -> bool:
        """Whether the oracle can do what a personality needs."""
        from teachers.personality import parse_personality

        make = self.oracle_class()
        able = make.abilities() if _is_oracle(make) else make(self.make_world().scratch).abilities()
        return parse_personality(personality).needs <= able

    def make_teacher(
        self,
        world: "World[Any, Any, Any]",
        personality: "str | Personality" = "oracle",
        *,
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: "Voice" = "plain",
        paraphrase: "Paraphrase" = "random",
    ) -> "Teacher":
        """A teacher for such a world; arguments and errors as in `teachers.teacher.Teacher`."""
        from teachers.teacher import Teacher

        return Teacher(
            self.oracle_class()(world.scratch),
            self.phrasebook(voice),
            personality,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            paraphrase=paraphrase,
        )

    def raw_env(self, *, seating: str = TUTORING, **settings: Any) -> "SeatsEnv":
        """The bare AEC environment.

        Args:
            seating: a module of `pz_envs.seatings`: `tutoring`, `classroom`, `panel`, ...
            settings: those of the seating, which its module tells, and the world's options.

        Raises:
            ValueError: no such seating, or an argument is not allowed.
        """
        return find_seating(seating).raw_env(self, **settings)

    def env(self, **settings: Any) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order; arguments as in `raw_env`."""
        return wrappers.OrderEnforcingWrapper(self.raw_env(**settings))

    def parallel_env(self, *, seating: str = TUTORING, **settings: Any) -> "ParallelEnv":
        """The parallel form, as the seating has it; arguments as in `raw_env`."""
        return find_seating(seating).parallel_env(self, **settings)


def _is_oracle(make: Any) -> "TypeGuard[type[Oracle[Any, Any]]]":
    return isinstance(make, type)


class Seating(ABC):
    """A way to seat teachers and students over a subject's worlds: a module of `pz_envs.seatings` with a `SEATING`."""

    @abstractmethod
    def raw_env(self, subject: Subject, **settings: Any) -> "SeatsEnv":
        """The bare AEC environment."""

    def parallel_env(self, subject: Subject, **settings: Any) -> "ParallelEnv":
        """The parallel form: all seats act, and those whose turn it is not are ignored."""
        from pettingzoo.utils.conversions import turn_based_aec_to_parallel

        return turn_based_aec_to_parallel(wrappers.OrderEnforcingWrapper(self.raw_env(subject, **settings)))


@cache
def seating_names() -> tuple[str, ...]:
    """The names of all seatings, sorted."""
    from pz_envs import seatings

    return tuple(sorted(module.name for module in pkgutil.iter_modules(seatings.__path__)))


def find_seating(name: str) -> Seating:
    """The seating of a name.

    Raises:
        ValueError: there is none of that name.
    """
    if name not in seating_names():
        from teachers.spec import unknown

        raise ValueError(unknown("seating", name, seating_names()))
    seating: Seating = importlib.import_module(f"pz_envs.seatings.{name}").SEATING
    return seating
