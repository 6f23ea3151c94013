"""The declaration of a family: what joins a world, an oracle and their phrases. Declaring imports neither."""

import importlib
import pkgutil
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any

from pettingzoo import register
from pettingzoo.utils import wrappers

if TYPE_CHECKING:
    from pettingzoo import AECEnv, ParallelEnv

    from pz_envs.tutoring import TutoringEnv
    from teachers.oracle import Oracle
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase
    from teachers.teacher import Teacher
    from worlds.world import World


@dataclass(frozen=True, kw_only=True)
class Family:
    """A family of environments: one module of the same basename in `worlds`, `teachers.oracles`, `teachers/phrases`
    and `pz_envs.families`.
    """  # noqa: D205

    name: str
    """The basename."""
    summary: str
    """One line for listings."""
    world: str
    """Name of the world's class."""
    oracle: str
    """Name of the oracle's class."""
    environments: Mapping[str, Mapping[str, Any]]
    """Per environment, named with its version as in `name-v0`, the world's options."""
    showcase: tuple[str, ...]
    """The environments that stand for the family in the quickstart study."""
    max_cycles: int
    """Turns of the student after which an episode is truncated."""
    repeated: bool = False
    """Whether success ends nothing: a one-step problem without state, asked again and again."""
    regret_unit: str
    """What regret counts, as in "extra moves"."""
    reward_only: str
    """Spec of the student that suits the family and learns from rewards alone."""
    extra: str = field(default="")
    """The extra of the distribution that the world needs, if the core does not do."""

    def _load(self, module: str, name: str) -> Any:
        try:
            return getattr(importlib.import_module(module), name)
        except ModuleNotFoundError as error:
            missing = f"llf-teacher[{self.extra}]" if self.extra else "llf-teacher"
            raise ModuleNotFoundError(
                f"the family {self.name!r} needs {error.name!r}, which is not installed; run: pip install '{missing}'",
                name=error.name,
            ) from error

    def make_world(self, **options: Any) -> "World":
        """A world.

        Raises:
            ValueError: an option is unknown or its value is not allowed.
            ModuleNotFoundError: an extra is not installed; the message has the pip line.
        """
        cls = self._load(f"worlds.{self.name}", self.world)
        try:
            return cls(**options)
        except TypeError as error:
            raise ValueError(f"{self.world} does not take these options: {error}") from None

    def oracle_class(self) -> "type[Oracle]":
        """The class of the family's oracles; errors as in `make_world`."""
        return self._load(f"teachers.oracles.{self.name}", self.oracle)

    def make_teacher(
        self,
        world: "World",
        personality: "str | Personality" = "oracle",
        *,
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: str = "plain",
        paraphrase: "Paraphrase" = "random",
    ) -> "Teacher":
        """A teacher for a world of this family; arguments and errors as in `teachers.teacher.Teacher`."""
        from teachers.phrasebook import load_phrasebook
        from teachers.teacher import Teacher

        oracle = self.oracle_class()
        return Teacher(
            oracle(world.scratch),
            load_phrasebook(self.name, oracle.__module__, voice),
            personality,
            instruction_type=instruction_type,
            feedback_type=feedback_type,
            paraphrase=paraphrase,
        )

    def raw_env(
        self,
        *,
        instruction_type: str = "b",
        feedback_type: str | Iterable[str] = "a",
        voice: str = "plain",
        paraphrase: "Paraphrase" = "random",
        max_cycles: int | None = None,
        render_mode: str | None = None,
        speech: str = "message",
        text: bool = False,
        cost: float = 0.01,
        budget: int | None = None,
        teacher_reward: Any = None,
        **options: Any,
    ) -> "TutoringEnv":
        """The bare AEC environment; see `pz_envs.tutoring.TutoringEnv`. Other arguments are the world's options."""
        from pz_envs.tutoring import TutoringEnv

        world = self.make_world(**options)
        tutor = self.make_teacher(
            world, instruction_type=instruction_type, feedback_type=feedback_type, voice=voice, paraphrase=paraphrase
        )
        return TutoringEnv(
            world,
            tutor,
            name=self.name,
            max_cycles=self.max_cycles if max_cycles is None else max_cycles,
            repeated=self.repeated,
            render_mode=render_mode,
            speech=speech,
            text=text,
            cost=cost,
            budget=budget,
            teacher_reward=teacher_reward,
        )

    def env(self, **kwargs: Any) -> "AECEnv":
        """The AEC environment with PettingZoo's check of the calling order."""
        return wrappers.OrderEnforcingWrapper(self.raw_env(**kwargs))

    def parallel_env(self, **kwargs: Any) -> "ParallelEnv":
        """The parallel form: both seats act, the seat whose turn it is not is ignored."""
        from pettingzoo.utils.conversions import turn_based_aec_to_parallel

        return turn_based_aec_to_parallel(self.env(**kwargs))

    def register(self) -> None:
        """Enter the environments into PettingZoo's registry as `llf/<environment>`."""
        for environment, options in self.environments.items():
            for env_type, function in (("aec", "env"), ("parallel", "parallel_env")):
                entry_point = f"pz_envs.families.{self.name}:{function}"
                register(env_type, f"llf/{environment}", entry_point=entry_point, kwargs=dict(options))


@cache
def all_families() -> tuple[Family, ...]:
    """Every family, sorted by name."""
    from pz_envs import families as package

    modules = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return tuple(importlib.import_module(f"{package.__name__}.{name}").FAMILY for name in modules)
