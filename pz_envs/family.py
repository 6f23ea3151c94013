"""The declaration of a family: a world, an oracle and their phrases, by name, without importing them."""

import contextlib
import importlib
import inspect
import os
import pkgutil
import re
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Any

from pettingzoo import register

from pz_envs.learning import Learning, check_learning
from pz_envs.subject import TUTORING, Subject, seating_names
from teachers.spec import signature_of
from worlds.extras import pip_install

if TYPE_CHECKING:
    from teachers.batches import OracleBatch
    from teachers.oracle import Oracle
    from teachers.phrasebook import Phrasebook
    from teachers.voice import Voice
    from worlds.batches import WorldBatch
    from worlds.pictures import Picture
    from worlds.posteriors import Posterior
    from worlds.world import World

PLUGINS = "llf_teacher.families"
"""The entry point group in which installed distributions declare families, each as `module:FAMILY`."""
_PREFIXES = ("llf-", "llf/", "verbal-")  # of ids, which the registries put before an environment's name
_ENVIRONMENT = re.compile(r"[A-Za-z0-9_-]+-v\d+")


@dataclass(frozen=True, kw_only=True)
class Family(Subject):
    """A family of environments.

    It has a module of the same name in `worlds`, `teachers.oracles`, `teachers/phrases` and `pz_envs.families`. A
    family of another distribution declares where its modules are.
    """

    name: str
    """The name of the modules."""
    summary: str
    """One line for listings."""
    world: str
    """Name of the world's class, or `module:class` if the module is not `worlds.<name>`."""
    oracle: str
    """Name of the oracle's class, or `module:class` if the module is not `teachers.oracles.<name>`."""
    phrases: str = ""
    """The phrases, as `package:file.toml`; empty: `teachers.phrases:<name>.toml`."""
    world_batch: str = ""
    """Name of the class of its worlds in arrays, or `module:class` if the module is not `worlds.batches.<name>`; empty
    if there is none.
    """
    oracle_batch: str = ""
    """Name of the class of its oracles in arrays, likewise of `teachers.batches.<name>`."""
    picture: str = ""
    """Name of the class of its pictures, or `module:class` if the module is not `worlds.pictures.<name>`; empty:
    pictures show the world's text.
    """
    posterior: str = ""
    """Name of the class of its posterior, or `module:class` if the module is not `worlds.posteriors.<name>`; empty if
    there is none.
    """
    environments: Mapping[str, Mapping[str, Any]]
    """Per environment, named with its version as in `name-v0`, the world's options."""
    showcase: tuple[str, ...]
    """The environments that represent the family in samples, tables and pages."""
    max_turns: int
    """Turns of the student after which an episode is truncated."""
    repeated: bool = False
    """Whether success ends no episode: the family is a one-step problem without state, asked repeatedly."""
    slow: bool = False
    """Whether the simulator is slow; tests and tables then play fewer episodes."""
    sampled: tuple[str, ...] = ()
    """The environments that have golden transcripts and are in the default tests; empty: all."""
    rules: int = 1
    """Version of the family's rules; it increases when the same seed and actions no longer give the same episode."""
    regret_unit: str
    """The unit of regret, such as "extra moves"."""
    learning: Learning
    """What can be learned from rewards alone."""
    visual: bool = False
    """Whether its worlds have an option `visual` that adds images to the observation."""
    aliases: Mapping[str, str] = field(default_factory=dict)
    """Per alias the environment."""
    alias_warning: str = ""
    """The warning for users of an alias."""
    extra: str = field(default="")
    """The extra of the distribution that the world needs; empty: none."""
    python_below: tuple[int, int] | None = None
    """The first version of Python for which a package that the world needs has no wheel; None: there is none."""
    distribution: str = "llf-teacher"
    """The distribution; for a plug-in, the entry point sets this field and the next two."""
    version: str = ""
    """The version of another distribution; empty for this one."""
    module: str = ""
    """The module of this declaration; empty: `pz_envs.families.<name>`."""

    def __post_init__(self) -> None:
        check_learning(self.learning)
        for name in (*self.environments, *self.aliases):
            for prefix in _PREFIXES:
                if name.startswith(prefix):
                    raise ValueError(
                        f"the family {self.name!r} names an environment {name!r}; names are without the prefix "
                        f"{prefix!r}, which ids get automatically; allowed: {name.removeprefix(prefix)!r}"
                    )

    def _load(self, where: str, package: str) -> Any:
        module, _, name = where.rpartition(":")
        try:
            return getattr(importlib.import_module(module or f"{package}.{self.name}"), name)
        except ModuleNotFoundError as error:
            ours = self.extra and self.distribution == "llf-teacher"
            other = f"{self.distribution}[{self.extra}]" if self.extra else self.distribution
            remedy = "run: " + (pip_install(self.extra) if ours else f"pip install '{other}'")
            if below := self._python_needed:
                remedy = f"it has no wheel for Python {below} and later: use an older one"
            raise ModuleNotFoundError(
                f"the family {self.name!r} needs {error.name!r}, which is not installed; {remedy}",
                name=error.name,
            ) from error

    @property
    def _python_needed(self) -> str:
        """The version of Python that must not be reached, if this one is not older; else empty."""
        below = self.python_below
        return f"{below[0]}.{below[1]}" if below and sys.version_info[:2] >= below else ""

    def make_world(self, /, **options: Any) -> "World[Any]":
        """A world.

        Raises:
            ValueError: an option is unknown or its value is not allowed.
            ModuleNotFoundError: an extra is not installed; the message has the pip line.
        """
        cls: type[World[Any]] = self._load(self.world, "worlds")
        allowed = self.options()
        if unknown_names := [name for name in options if name not in allowed]:
            from teachers.spec import unknown

            hint = f"{unknown('option', unknown_names[0], allowed)}{self.elsewhere(unknown_names[0])}"
            raise ValueError(f"{cls.__name__} does not take these options: {hint}")
        return cls(**options)

    @property
    def code_modules(self) -> tuple[str, ...]:
        """The modules of a plug-in that declare it and have its classes."""
        classes = (self.world, self.oracle, self.world_batch, self.oracle_batch, self.picture, self.posterior)
        named = (each.rpartition(":")[0] for each in classes)
        return tuple(dict.fromkeys(filter(None, (self.module, *named))))

    def elsewhere(self, option: str) -> str:
        """The families whose worlds have an option, or what else takes it, to complete a message; empty without any."""
        able = []
        for family in all_families():
            with contextlib.suppress(ModuleNotFoundError):  # an extra is not installed
                able += [family.name] if option in family.options() else []
        return f"; families with the option {option!r}: {', '.join(able)}" if able else super().elsewhere(option)

    def options(self) -> tuple[str, ...]:
        """The names of the world's options; errors as in `make_world`."""
        return tuple(signature_of(self._load(self.world, "worlds")).parameters)

    def oracle_class(self) -> "type[Oracle[Any, Any]]":
        """The class of the family's oracles; errors as in `make_world`."""
        cls: type[Oracle[Any, Any]] = self._load(self.oracle, "teachers.oracles")
        return cls

    def batch_options(self) -> tuple[str, ...]:
        """The names of the options that `make_batch` takes beside the world's."""
        own = inspect.signature(self._load(self.world_batch, "worlds.batches")).parameters
        return tuple(name for name, each in own.items() if each.kind == each.KEYWORD_ONLY)

    def make_batch(self, rows: int, **options: Any) -> "tuple[WorldBatch[Any, Any], OracleBatch[Any]]":
        """Worlds in arrays and their oracles in arrays.

        Args:
            rows: number of worlds.
            options: the world's, and those of `batch_options`.

        Raises:
            ValueError: the family has no batch, or an option is unknown or its value is not allowed.
        """
        if not self.world_batch:
            able = ", ".join(family.name for family in all_families() if family.world_batch)
            raise ValueError(
                f"the family {self.name!r} cannot be played in arrays; allowed: {able}; for others there is "
                "vectorization_mode='sync'"
            )
        own = {name: options.pop(name) for name in self.batch_options() if name in options}
        world = self.make_world(**options)
        worlds = self._load(self.world_batch, "worlds.batches")(world, rows, **own)
        oracle = self.oracle_class()(world.scratch)
        return worlds, self._load(self.oracle_batch, "teachers.batches")(oracle, worlds)

    @property
    def drawn(self) -> bool:
        """Whether it has a class of pictures."""
        return bool(self.picture)

    def make_picture(self, world: "World[Any]") -> "Picture[Any]":
        """The picture of a world of this family."""
        if not self.picture:
            return super().make_picture(world)
        picture: Picture[Any] = self._load(self.picture, "worlds.pictures")(world.scratch())
        return picture

    @property
    def posterior_needs(self) -> Mapping[str, Any]:  # type: ignore[override]  # of a base that has none
        """Options that a world needs to have a posterior, beside the defaults."""
        return self._posterior.needs if self.posterior else super().posterior_needs

    @property
    def posterior_abilities(self) -> frozenset[str]:  # type: ignore[override]  # of a base that has none
        """What teachers can do by the posterior; see `teachers.oracle.ABILITIES`."""
        from teachers.witness import abilities_of

        return abilities_of(self._posterior) if self.posterior else frozenset()

    def make_posterior(self, world: "World[Any]") -> "Posterior[Any]":
        """The posterior of a world of this family; errors as in `Subject.make_posterior`."""
        if not self.posterior:
            able = ", ".join(family.name for family in all_families() if family.posterior)
            raise ValueError(f"the family {self.name!r} has no posterior; families with one: {able}")
        return self._posterior(world.scratch())

    @property
    def _posterior(self) -> "type[Posterior[Any]]":
        cls: type[Posterior[Any]] = self._load(self.posterior, "worlds.posteriors")
        return cls

    def label(self, seating: str, options: Mapping[str, Any]) -> str:
        """The PettingZoo id of the environment with these options, or the family's name."""
        own = {name for each in self.environments.values() for name in each}
        given = {name: value for name, value in options.items() if name in own}
        for environment, declared in self.environments.items():
            if declared == given:
                return f"llf/{_seated(environment, seating)}"
        return self.name

    def missing(self) -> str:
        """Why the family cannot be played here: what it needs is not installed. Empty if it can."""
        try:
            if self.extra or self._python_needed:
                self.oracle_class()
        except ModuleNotFoundError as error:
            return f"{error}"
        return ""

    def phrasebook(self, voice: "Voice" = "plain") -> "Phrasebook":
        """The phrases of the family's teachers."""
        from teachers.phrasebook import load_phrasebook

        source = self.phrases or f"teachers.phrases:{self.name}.toml"
        return load_phrasebook(source, self.oracle_class().__module__, voice)

    def register(self) -> None:
        """Enter the environments into PettingZoo's registry as `llf/<environment>`."""
        module = self.module or f"pz_envs.families.{self.name}"
        for environment, options in self.environments.items():
            for env_type, function in _FORMS.items():
                entry_point = f"{module}:{function}"
                register(env_type, f"llf/{environment}", entry_point=entry_point, kwargs=dict(options))
            for seating, (env_type, function) in product(seating_names(), _FORMS.items()):
                if seating != TUTORING:
                    seated, name = {**options, "seating": seating}, _seated(environment, seating)
                    register(env_type, f"llf/{name}", entry_point=f"{module}:{function}", kwargs=seated)


def _seated(environment: str, seating: str) -> str:
    """The name of an environment in a seating."""
    name, _, version = environment.rpartition("-")
    return environment if seating == TUTORING else f"{name}-{seating}-{version}"


_FORMS = {"aec": "env", "parallel": "parallel_env"}  # PettingZoo's function names and our method names


@cache
def own_families() -> tuple[Family, ...]:
    """The families of this distribution, sorted by name."""
    from pz_envs import families as package

    modules = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return tuple(importlib.import_module(f"{package.__name__}.{name}").FAMILY for name in modules)


@cache
def all_families() -> tuple[Family, ...]:
    """Every family of this distribution and of installed plug-ins, sorted by name."""
    return tuple(sorted(_with_plugins(list(own_families())), key=lambda family: family.name))


def families_to_register() -> tuple[Family, ...]:
    """The families to register on import: all if a quick search finds a plug-in, else this distribution's.

    The full search by `importlib.metadata` takes a tenth of the time in which Gymnasium is imported.
    """
    return all_families() if any(map(_has_plugin, sys.path)) else own_families()


def _has_plugin(folder: str) -> bool:
    """Whether a distribution in a folder has entry points of our group."""
    with contextlib.suppress(OSError):
        for name in os.listdir(folder or os.curdir):
            if name.endswith((".dist-info", ".egg-info")):
                with contextlib.suppress(OSError), open(os.path.join(folder, name, "entry_points.txt"), "rb") as file:
                    if PLUGINS.encode() in file.read():
                        return True
    return False


def _with_plugins(families: list[Family]) -> list[Family]:
    """The given families and the families of plug-ins; a plug-in that raises an error is left out with a warning."""
    from importlib import metadata

    found = sorted(metadata.entry_points(group=PLUGINS), key=lambda each: (each.name, each.value))
    for entry in found:
        distribution, version = (entry.dist.name, entry.dist.version) if entry.dist else (entry.module, "")
        try:
            family = entry.load()
            if not isinstance(family, Family):
                raise TypeError(f"{entry.value} must be a pz_envs.family.Family, got {family!r}")
            _check_plugin(family, families)
            importlib.import_module(entry.module).env  # noqa: B018 (PettingZoo needs it)
        except Exception as error:
            message = f"the family {entry.name!r} of {distribution} ({entry.value}) is left out: {error!r}"
            warnings.warn(message, RuntimeWarning, stacklevel=2)
            continue
        families = [*families, replace(family, module=entry.module, distribution=distribution, version=version)]
    return families


def _check_plugin(family: Family, others: list[Family]) -> None:
    if not family.environments:
        raise ValueError("it declares no environments; it must declare at least one")
    for name in family.environments:
        if not _ENVIRONMENT.fullmatch(name):
            raise ValueError(f"environments must be named as in 'name-v0', got {name!r}")
    for name in (*family.showcase, *family.sampled):
        if name not in family.environments:
            raise ValueError(f"showcase and sampled must name its environments, got {name!r}")
    for other in others:
        if family.name == other.name or family.environments.keys() & other.environments.keys():
            raise ValueError(
                f"its name or an environment's is taken by the family {other.name!r} of {other.distribution}; choose "
                "another name"
            )
