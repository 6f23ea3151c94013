"""What can be taught, and how it can be seated."""

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, TypeGuard, Unpack

from pz_envs.learning import Learning
from pz_envs.settings import Settings, SettingsKeywords, TeacherKeywords, takes_settings
from teachers.spec import unknown

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.parallel_seats import InTurns, ParallelSeats
    from pz_envs.seats import SeatsEnv
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Phrasebook
    from teachers.teacher import Teacher
    from teachers.voice import Voice
    from worlds.pictures import Picture
    from worlds.world import World

TUTORING = "tutoring"
"""The seating of one teacher and one student, which is meant where none is named."""


class SeatsKeywords(SettingsKeywords, total=False):
    """What the doors of PettingZoo take besides, as keywords."""

    max_cycles: int | None
    episodes: int


_shown = takes_settings(names={"max_turns": "max_cycles"})


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
        **wording: Unpack[TeacherKeywords],
    ) -> "Teacher":
        """A teacher for such a world; arguments and errors as in `teachers.teacher.Teacher`."""
        from teachers.teacher import Teacher

        settings: dict[str, Any] = {**wording}
        phrasebook = self.phrasebook(settings.pop("voice", "plain"))
        return Teacher(self.oracle_class()(world.scratch), phrasebook, personality, **settings)

    @_shown
    def raw_env(
        self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Unpack[SeatsKeywords]
    ) -> "SeatsEnv":
        """The bare AEC environment.

        Args:
            seating: a module of `pz_envs.seatings`: `tutoring`, `classroom`, `panel`, ...
            settings: of the lesson; None: the defaults.
            keywords: fields of `Settings` that are otherwise (`max_turns` is called `max_cycles`; where several sit,
                `speech` is `kinds` by default), the world's options, `episodes` of a lifetime, which is then one game
                (see `pz_envs.lifetimes.LifetimeEnv`), and settings of the seating, such as `students` of a classroom.

        Raises:
            ValueError: no such seating, or an argument is not allowed.
        """
        found, lesson, own = self._read(seating, settings, keywords)
        env = found.seats(self, lesson, **own)
        env.label = self.label(seating, lesson.options)
        return env

    @_shown
    def env(
        self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Unpack[SeatsKeywords]
    ) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order; arguments as in `raw_env`."""
        from pz_envs.seats import OrderEnforcing

        return OrderEnforcing(self.raw_env(seating=seating, settings=settings, **keywords))

    @_shown
    def parallel_env(
        self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Unpack[SeatsKeywords]
    ) -> "ParallelEnv":
        """The parallel form, as the seating has it; arguments as in `raw_env`."""
        found, lesson, own = self._read(seating, settings, keywords)
        env: InTurns | ParallelSeats = found.parallel_env(self, lesson, **own)
        env.env.label = self.label(seating, lesson.options)
        return env

    def label(self, seating: str, options: Mapping[str, Any]) -> str:
        """The name of an environment with these options of the world in its `repr`."""
        return self.name

    def _read(
        self, name: str, settings: Settings | None, keywords: Mapping[str, Any]
    ) -> "tuple[Seating, Settings, dict[str, Any]]":
        """A seating, the settings of its lessons, and its own arguments."""
        seating = find_seating(name)
        names = seating.arguments()
        own = {key: value for key, value in keywords.items() if key in names}
        rest = {key: value for key, value in keywords.items() if key not in names}
        if "max_cycles" in rest:
            rest["max_turns"] = rest.pop("max_cycles")
        defaults = {**seating.defaults, **({"until_success": True} if own.get("episodes", 1) != 1 else {})}
        others = (*names, "max_cycles")
        lesson = Settings.of(self.name, rest, self.options(), given=settings, others=others, **defaults)
        return seating, lesson, own


def _is_oracle(make: Any) -> "TypeGuard[type[Oracle[Any, Any]]]":
    return isinstance(make, type)


class Seating(ABC):
    """A way to seat teachers and students over a subject's worlds: a module of `pz_envs.seatings` with a `SEATING`."""

    defaults: ClassVar[Mapping[str, Any]] = {}
    """Fields of `Settings` whose defaults are others here."""

    @abstractmethod
    def raw_env(self, subject: Subject, settings: Settings, *args: Any, **own: Any) -> "SeatsEnv":
        """The bare AEC environment; a seating has arguments of its own as keywords."""

    def parallel_env(self, subject: Subject, settings: Settings, *args: Any, **own: Any) -> "InTurns | ParallelSeats":
        """The parallel form: all seats act, and those whose turn it is not are ignored."""
        from pz_envs.parallel_seats import InTurns
        from pz_envs.seats import OrderEnforcing

        return InTurns(OrderEnforcing(self.seats(subject, settings, **own)))

    def seats(self, subject: Subject, settings: Settings, *, episodes: int = 1, **own: Any) -> "SeatsEnv":
        """The bare AEC environment, or a lifetime in it of so many episodes.

        Raises:
            ValueError: an argument is not allowed.
        """
        if isinstance(episodes, bool) or not isinstance(episodes, int) or episodes < 1:
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        env = self.raw_env(subject, settings, **own)
        if episodes == 1:
            return env
        from pz_envs.lifetimes import LifetimeEnv

        return LifetimeEnv(env, episodes)

    def arguments(self) -> tuple[str, ...]:
        """The names of its own arguments."""
        doors = (self.raw_env, self.parallel_env, self.seats)
        named = (each for door in doors for each in inspect.signature(door).parameters.values())
        return tuple(dict.fromkeys(each.name for each in named if each.kind == each.KEYWORD_ONLY))


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
        raise ValueError(unknown("seating", name, seating_names()))
    seating: Seating = importlib.import_module(f"pz_envs.seatings.{name}").SEATING
    return seating
