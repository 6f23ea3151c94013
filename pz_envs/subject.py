"""Subjects, which teachers teach, and seatings, which place teachers and students over them."""

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, TypeGuard, Unpack

from pz_envs.learning import Learning
from pz_envs.settings import Settings, TeacherKeywords, takes_settings
from teachers.spec import unknown

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.parallel_seats import ParallelSeats, TurnBasedParallelEnv
    from pz_envs.seats import SeatsEnv
    from teachers.batches import OracleBatch
    from teachers.information import Information, PosteriorContext
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Phrasebook
    from teachers.schema import Vocabulary
    from teachers.teacher import Teacher
    from teachers.voice import Voice
    from worlds.batches import WorldBatch
    from worlds.pictures import Picture
    from worlds.posteriors import Posterior
    from worlds.world import World

GYM = "gym:"
"""The prefix of ids of Gymnasium's registry; see `pz_envs.registered`."""
TUTORING = "tutoring"
"""The default seating: one teacher and one student."""
_OF_TEACHER_ENV = ("actions", "announce", "same_world", "vary")
"""Arguments that only `TeacherEnv` takes, beside `student`."""


_shown = takes_settings(names={"max_turns": "max_cycles"})


class Subject(ABC):
    """A subject: it makes worlds, and teachers and environments for them."""

    name: str
    summary: str
    """One line for listings."""
    max_turns: int
    """Turns of the student after which an episode is truncated."""
    repeated: bool
    """Whether success ends no episode: the subject is a one-step problem without state, asked repeatedly."""
    regret_unit: str
    """The unit of regret, such as "extra moves"."""
    learning: Learning
    """What can be learned from rewards alone."""
    visual: bool = False
    """Whether its worlds have an option `visual` that adds images to the observation."""
    rules: int = 1
    """Version of the rules; it increases when the same seed and actions no longer give the same episode."""
    distribution: str = "llf-teacher"
    """The distribution that has the worlds."""
    version: str = ""
    """The version of another distribution; empty for this one."""
    world_batch: str = ""
    """The class of its worlds in arrays; empty if there is none."""

    @abstractmethod
    def make_world(self, /, **options: Any) -> "World[Any, Any, Any]":
        """A new world."""

    @abstractmethod
    def oracle_class(self) -> "Callable[[Callable[[], World[Any, Any, Any]]], Oracle]":
        """A function that makes an oracle, given a function that makes scratch worlds."""

    @abstractmethod
    def phrasebook(self, voice: "Voice" = "plain") -> "Phrasebook":
        """The phrases of the teachers."""

    def options(self) -> tuple[str, ...]:
        """The names of the world's options."""
        return ()

    @property
    def code_modules(self) -> tuple[str, ...]:
        """The modules with the code of its worlds and its oracle, if this distribution does not have them."""
        return ()

    def elsewhere(self, option: str) -> str:
        """What takes an option that this subject lacks, to complete a message; empty if nothing does."""
        if option == "student":
            return (
                "; a student is for TeacherEnv(student=...), or for PettingZoo's seats a partner in "
                "pz_envs.parallel_seats.ParallelSeats(env, {'student_0': policy})"
            )
        return f"; {option!r} is an argument of TeacherEnv" if option in _OF_TEACHER_ENV else ""

    def for_lesson(self, settings: Settings) -> "Subject":
        """The subject of a lesson with these settings; a new subject if its teachers plan for options and turns."""
        return self

    @property
    def drawn(self) -> bool:
        """Whether students may see pictures of its worlds."""
        return False

    def missing(self) -> str:
        """Why it cannot be taught here: something is not installed. Empty if it can."""
        return ""

    def batch_options(self) -> tuple[str, ...]:
        """The names of the options that `make_batch` takes beside the world's."""
        return ()

    def make_batch(self, rows: int, **options: Any) -> "tuple[WorldBatch[Any, Any], OracleBatch[Any]]":
        """Worlds in arrays and their oracles in arrays.

        Raises:
            ValueError: there are none.
        """
        raise ValueError(f"{self.name} cannot be played in arrays; leave out vectorization_mode, or set it to 'sync'")

    def taught_world(self, **options: Any) -> "World[Any, Any, Any]":
        """The world of a new environment."""
        return self.make_world(**options)

    def turns(self, given: int | None = None, **options: Any) -> int:
        """The turns after which an episode is truncated: the given number, or that of a world with these options.

        Raises:
            ValueError: the teacher has planned for another number.
        """
        return self.max_turns if given is None else given

    def make_picture(self, world: "World[Any, Any, Any]") -> "Picture[Any]":
        """The picture of a world of this subject; by default its description as text."""
        from worlds.pictures import TextPicture

        return TextPicture(world.scratch())

    posterior: str = ""
    """The class of its worlds' posterior; empty if there is none."""
    posterior_needs: Mapping[str, Any] = MappingProxyType({})
    """Options that a world needs to have a posterior, beside the defaults."""

    posterior_abilities: frozenset[str] = frozenset()
    """What teachers can do by the posterior; see `teachers.oracle.ABILITIES`."""

    def make_posterior(self, world: "World[Any, Any, Any]") -> "Posterior[Any]":
        """The posterior of a world of this subject.

        Raises:
            ValueError: there is no posterior, or none with the world's options; the message says why.
        """
        raise ValueError(f"the lesson {self.name!r} has no posterior; allowed: families that declare one")

    def make_posterior_context(self, world: "World[Any, Any, Any]") -> "PosteriorContext":
        """What is needed to infer what a student in such a world knows; errors as in `make_posterior`."""
        from teachers.information import PosteriorContext

        return PosteriorContext(self.make_posterior(world), self.oracle_class()(world.scratch))

    def make_information(self, world: "World[Any, Any, Any]", seed: int, worlds: int | None = None) -> "Information":
        """Measures what a student of an episode can know, and how much claims tell it.

        Args:
            world: the world of the episode; it does not change.
            seed: the seed of the episode.
            worlds: number of worlds for measuring a claim; None: `teachers.information.WORLDS`.

        Raises:
            ValueError: see `make_posterior` and `teachers.information.Information`.
        """
        from teachers.information import Information
        from teachers.seeds import Seeds

        return Information(self.make_posterior_context(world), Seeds(seed).stream("information"), worlds)

    def serves(self, personality: "str | Personality", **options: Any) -> bool:
        """Whether a world with these options has all that a personality needs."""
        from teachers.personality import parse_personality

        make = self.oracle_class()
        able = make.abilities() if _is_oracle(make) else make(self.make_world().scratch).abilities()
        if self.posterior_needs.items() <= options.items():
            able |= self.posterior_abilities
        return parse_personality(personality).needs <= able

    def vocabulary(self, world: "World[Any, Any, Any] | None" = None) -> "Vocabulary":
        """The claims that teachers can state as JSON: their JSON Schema, and the functions that make them.

        Args:
            world: decides which actions there are; None: a world without options.
        """
        from teachers.schema import Vocabulary

        return Vocabulary.of(self.oracle_class()((world or self.make_world()).scratch))

    def make_teacher(
        self,
        world: "World[Any, Any, Any]",
        personality: "str | Personality" = "oracle",
        **wording: Unpack[TeacherKeywords],
    ) -> "Teacher":
        """A teacher for a world of this subject; arguments and errors as in `teachers.teacher.Teacher`."""
        from teachers.oracle import POSTERIOR
        from teachers.personality import parse_personality
        from teachers.teacher import Teacher

        settings: dict[str, Any] = {**wording}
        phrasebook = self.phrasebook(settings.pop("voice", "plain"))
        personality = parse_personality(personality)
        if POSTERIOR in personality.needs:
            try:
                settings["posterior_context"] = self.make_posterior_context(world)
            except ValueError as error:
                raise ValueError(
                    f"the personality {personality} needs a posterior: {error}; elsewhere use another, such as oracle"
                ) from None
        return Teacher(self.oracle_class()(world.scratch), phrasebook, personality, **settings)

    @_shown
    def raw_env(self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Any) -> "SeatsEnv":
        """The bare AEC environment.

        Args:
            seating: a module of `pz_envs.seatings`: `tutoring`, `classroom`, `panel`, ...
            settings: the settings of the lesson; None: the defaults.
            keywords: fields of `Settings` that replace them (`max_turns` is called `max_cycles`; in classrooms and
                panels `speech` is `kinds` by default), the world's options, `episodes` of a lifetime (see
                `pz_envs.lifetime_env.LifetimeEnv`), and arguments of the seating, such as `students` of a classroom.

        Raises:
            ValueError: the seating is unknown, or an argument is not allowed.
        """
        found, lesson, own = self._read(seating, settings, keywords)
        env = found.seats(self.for_lesson(lesson), lesson, **own)
        env.label = self.label(seating, lesson.options)
        return env

    @_shown
    def env(self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Any) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order; arguments as in `raw_env`."""
        from pz_envs.seats import OrderEnforcing

        return OrderEnforcing(self.raw_env(seating=seating, settings=settings, **keywords))

    @_shown
    def parallel_env(
        self, *, seating: str = TUTORING, settings: Settings | None = None, **keywords: Any
    ) -> "ParallelEnv":
        """The parallel form of the seating; arguments as in `raw_env`."""
        found, lesson, own = self._read(seating, settings, keywords)
        env: TurnBasedParallelEnv | ParallelSeats = found.parallel_env(self.for_lesson(lesson), lesson, **own)
        env.env.label = self.label(seating, lesson.options)
        return env

    def label(self, seating: str, options: Mapping[str, Any]) -> str:
        """The name in the `repr` of an environment with these options of the world."""
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
        lesson = Settings.of(
            self.name, rest, self.options(), given=settings, others=others, elsewhere=self.elsewhere, **defaults
        )
        return seating, lesson, own


def _is_oracle(make: Any) -> "TypeGuard[type[Oracle[Any, Any]]]":
    return isinstance(make, type)


class Seating(ABC):
    """A way to place teachers and students over a subject's worlds: a module of `pz_envs.seatings` with a `SEATING`."""

    defaults: ClassVar[Mapping[str, Any]] = {}
    """Fields of `Settings` whose defaults this seating changes."""

    @abstractmethod
    def raw_env(self, subject: Subject, settings: Settings, *args: Any, **own: Any) -> "SeatsEnv":
        """The bare AEC environment; keyword-only arguments are the seating's own."""

    def parallel_env(
        self, subject: Subject, settings: Settings, *args: Any, **own: Any
    ) -> "TurnBasedParallelEnv | ParallelSeats":
        """The parallel form: every agent acts, and only the selected agent's action counts."""
        from pz_envs.parallel_seats import TurnBasedParallelEnv
        from pz_envs.seats import OrderEnforcing

        return TurnBasedParallelEnv(OrderEnforcing(self.seats(subject, settings, **own)))

    def seats(self, subject: Subject, settings: Settings, *, episodes: int = 1, **own: Any) -> "SeatsEnv":
        """The bare AEC environment, or with `episodes` above 1 a lifetime in it.

        Raises:
            ValueError: an argument is not allowed.
        """
        if isinstance(episodes, bool) or not isinstance(episodes, int) or episodes < 1:
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        env = self.raw_env(subject, settings, **own)
        if episodes > 1:
            from pz_envs.lifetime_env import LifetimeEnv

            env = LifetimeEnv(env, episodes)
        if settings.teacher_numbers:
            env.flatten_teachers()
        return env

    def arguments(self) -> tuple[str, ...]:
        """The names of the seating's own arguments."""
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
        ValueError: the name is unknown.
    """
    if name not in seating_names():
        raise ValueError(unknown("seating", name, seating_names()))
    seating: Seating = importlib.import_module(f"pz_envs.seatings.{name}").SEATING
    return seating
