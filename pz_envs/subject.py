"""What can be taught, and how it can be seated."""

import importlib
import inspect
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, ParamSpec, TypeGuard, TypeVar

from pz_envs.learning import Learning

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.parallel_seats import InTurns, ParallelSeats
    from pz_envs.seats import SeatsEnv
    from teachers.atoms import Moment
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase, Phrasebook
    from teachers.teacher import Teacher
    from teachers.voice import Voice
    from worlds.pictures import Picture
    from worlds.world import World

TUTORING = "tutoring"
"""The seating of one teacher and one student, which is meant where none is named."""


P = ParamSpec("P")
R = TypeVar("R")


def settings_of(*doors: Callable[..., Any]) -> tuple[str, ...]:
    """The names of the arguments of functions or classes, each once."""
    found = (each for door in doors for each in inspect.signature(door).parameters.values())
    return tuple(dict.fromkeys(each.name for each in found if each.kind != each.VAR_KEYWORD and each.name != "self"))


def _takes(like: Callable[P, Any]) -> Callable[[Callable[..., R]], Callable[P, R]]:
    """A function that takes its arguments by name as they come, and shows those of another one as its own."""

    def shown(function: Callable[..., R]) -> Callable[P, R]:
        result = inspect.signature(function).return_annotation
        function.__signature__ = inspect.signature(like).replace(return_annotation=result)  # type: ignore[attr-defined]  # what `inspect.signature` looks for
        return function

    return shown


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

    def is_over(self, moment: "Moment[Any]") -> bool:
        """Whether a played episode stops with a moment: it ended, or the task is solved and not asked repeatedly.

        LLF-Bench's evaluation stops so, whatever `until_success` says.
        """
        return moment.over or (moment.success and not self.repeated)

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

    def _arguments(
        self,
        *,
        seating: str = TUTORING,
        teacher: "str | Personality | Teacher" = "oracle",
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: "Voice" = "plain",
        paraphrase: "Paraphrase" = "random",
        speech: str = "message",
        text: bool = False,
        max_cycles: int | None = None,
        cost: float = 0.01,
        budget: int | None = None,
        episodes: int = 1,
        render_mode: str | None = None,
        privileged_info: bool = False,
        **options: Any,
    ) -> None:
        """What the three forms take; a seating may have other defaults."""

    @_takes(_arguments)
    def raw_env(self, *, seating: str = TUTORING, **settings: Any) -> "SeatsEnv":
        """The bare AEC environment.

        Args:
            seating: a module of `pz_envs.seatings`: `tutoring`, `classroom`, `panel`, ...
            teacher: a personality's spec string, a `Personality` or a `Teacher`; a panel has `teachers`, a list.
            instruction_type, feedback_type, voice, paraphrase: of the teacher; see `teachers.teacher.Teacher`.
            speech: what the teacher's action is, `message`, `kinds` or `claims`; where several sit, `kinds` is the
                default.
            text: text in, text out for the student.
            max_cycles: turns of the student after which an episode is truncated; None: the family's.
            cost: paid by the teacher for each atom that it says.
            budget: atoms that it may say in an episode, or in a lifetime; None: any number.
            episodes: of a lifetime, which is then one game; see `pz_envs.lifetimes.LifetimeEnv`.
            render_mode: None, `ansi`, `rgb_array` or `human`.
            privileged_info: show the truth in frames.
            options: further settings of the seating, such as `students` of a classroom, which its module tells, and the
                world's options.

        Raises:
            ValueError: no such seating, or an argument is not allowed.
        """
        env = self._seating(seating, settings).seats(self, **settings)
        env.label = self.label(seating, settings)
        return env

    @_takes(_arguments)
    def env(self, **settings: Any) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order; arguments as in `raw_env`."""
        from pz_envs.seats import OrderEnforcing

        return OrderEnforcing(self.raw_env(**settings))

    @_takes(_arguments)
    def parallel_env(self, *, seating: str = TUTORING, **settings: Any) -> "ParallelEnv":
        """The parallel form, as the seating has it; arguments as in `raw_env`."""
        env: InTurns | ParallelSeats = self._seating(seating, settings).parallel_env(self, **settings)
        env.env.label = self.label(seating, settings)
        return env

    def label(self, seating: str, settings: Mapping[str, Any]) -> str:
        """What such an environment is called by its `repr`."""
        return self.name

    def _seating(self, name: str, settings: Iterable[str]) -> "Seating":
        """A seating that knows these settings, or leaves them to the world, which does.

        Raises:
            ValueError: there is no such seating, or neither knows a setting.
        """
        seating = find_seating(name)
        known = {*seating.settings(), *self.options()}
        if strange := [each for each in settings if each not in known]:
            from teachers.spec import unknown

            why = unknown("option", strange[0], sorted(known))
            raise ValueError(f"{self.name} does not take these options: {why}")
        return seating


def _is_oracle(make: Any) -> "TypeGuard[type[Oracle[Any, Any]]]":
    return isinstance(make, type)


class Seating(ABC):
    """A way to seat teachers and students over a subject's worlds: a module of `pz_envs.seatings` with a `SEATING`."""

    @abstractmethod
    def raw_env(self, subject: Subject, **settings: Any) -> "SeatsEnv":
        """The bare AEC environment."""

    def parallel_env(self, subject: Subject, **settings: Any) -> "InTurns | ParallelSeats":
        """The parallel form: all seats act, and those whose turn it is not are ignored."""
        from pz_envs.parallel_seats import InTurns
        from pz_envs.seats import OrderEnforcing

        return InTurns(OrderEnforcing(self.seats(subject, **settings)))

    def seats(self, subject: Subject, *, episodes: int = 1, **settings: Any) -> "SeatsEnv":
        """The bare AEC environment, or a lifetime in it of so many episodes, which success ends unless it is said.

        Raises:
            ValueError: an argument is not allowed.
        """
        if isinstance(episodes, bool) or not isinstance(episodes, int) or episodes < 1:
            raise ValueError(f"episodes must be an integer of at least 1, got {episodes!r}")
        if episodes == 1:
            return self.raw_env(subject, **settings)
        from pz_envs.lifetimes import LifetimeEnv

        return LifetimeEnv(self.raw_env(subject, **({"until_success": True} | settings)), episodes)

    def settings(self) -> tuple[str, ...]:
        """The names of what it takes: its own settings, and those of tutoring, of which the others are made."""
        named = settings_of(self.raw_env, self.parallel_env, self.seats, find_seating(TUTORING).raw_env)
        return tuple(name for name in named if name != "subject")


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
