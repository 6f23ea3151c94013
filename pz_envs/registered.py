"""Environments of Gymnasium's registry as subjects: `gym:Taxi-v4`, `gym:package.module:ID`."""

import contextlib
import importlib
import inspect
import json
import random
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache, cached_property, partial
from importlib import metadata
from types import ModuleType
from typing import Any, Unpack

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec, load_env_creator
from rapidfuzz import fuzz

from pz_envs.learning import StateValues
from pz_envs.lesson import Lesson, least, limits_of
from pz_envs.settings import FIELDS, Settings, TeacherKeywords
from pz_envs.subject import GYM, Subject
from teachers.oracle import Oracle
from teachers.personality import Personality
from teachers.phrasebook import Phrasebook
from teachers.planning import Planner
from teachers.planning.planner import REWARDS, PlanningError, shared_draws, wrong_form
from teachers.spec import unknown
from teachers.teacher import Teacher
from teachers.voice import Voice
from worlds.extras import pip_install
from worlds.world import World
from worlds.wrapped.gym_world import GymWorld, same

__all__ = ["Registered", "RegisteredLesson", "registered"]

_HOMES = {"BabyAI-": "minigrid", "MiniGrid-": "minigrid", "highway-": "highway_env"}
"""By the beginnings of ids, the packages that register them when they are imported."""
_EXTRAS = {"Box2D": "box2d", "minigrid": "minigrid"}
"""By package the extra that installs it."""
_OURS = ("llf-", "verbal-", "teacher/")
_MAKES = ("max_episode_steps",)  # arguments of `gymnasium.make` that matter here
_KEPT = 8  # planned lessons that are kept, per id
_VERSION = re.compile(r"-v\d+$")
_NEAR, _LIKE = 3, 75.0  # greatest number of suggested ids, and their least similarity in percent


class Registered(Subject):
    """An environment of Gymnasium's registry, with a planned teacher.

    Its options are the arguments of `gymnasium.make` and `oracle`, the spec string of a planner: `auto`,
    `exact(gamma=0.95)`, or `rewards` for rewards in words. `for_lesson` plans for options and turns; it makes and keeps
    a `pz_envs.lesson.Lesson`.

    Args:
        spec: the environment's spec.
        module: a module to import for it; empty: none.
    """

    repeated = False
    regret_unit = "value lost"
    learning = StateValues()

    def __init__(self, spec: EnvSpec, module: str = "") -> None:
        self.spec, self.module = spec, module
        self.id = f"{GYM}{module}{':' * bool(module)}{spec.id}"
        """The id; other processes make the same environment from it."""
        self.name = re.sub(r"[^\w.-]", "-", f"gym-{spec.id}")
        self._lessons: dict[str, RegisteredLesson] = {}
        self._limits: dict[str, list[Any]] = {}

    def __repr__(self) -> str:
        return f"<Registered {self.id}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return registered, (self.id,)

    @property
    def max_turns(self) -> int:  # type: ignore[override]  # computed on demand
        """Turns of the student after which an episode is truncated, with the default options."""
        return self.turns()

    @cached_property
    def distribution(self) -> str:  # type: ignore[override]  # likewise
        """The distribution that has the environment; empty if it is in none."""
        package = inspect.getmodule(self._creator).__name__.partition(".")[0]  # type: ignore[union-attr]  # imported before
        with contextlib.suppress(metadata.PackageNotFoundError):
            return metadata.distribution(package).name
        return next(iter(metadata.packages_distributions().get(package, ())), "")

    @cached_property
    def version(self) -> str:  # type: ignore[override]  # likewise
        """The version of that distribution."""
        return metadata.version(self.distribution) if self.distribution else ""

    @property
    def code_modules(self) -> tuple[str, ...]:
        """The modules of what makes the environment, and of what registers it."""
        found = getattr(inspect.getmodule(self._creator), "__name__", "")
        return tuple(dict.fromkeys(filter(None, (found, self.module))))

    @cached_property
    def _creator(self) -> Any:
        entry: Any = self.spec.entry_point
        try:
            return load_env_creator(entry) if isinstance(entry, str) else entry
        except Exception as error:  # its module may raise anything, and its message says what is not installed
            raise ValueError(f"{self.id} cannot be loaded: {type(error).__name__}: {error}") from error

    @property
    def summary(self) -> str:  # type: ignore[override]  # likewise
        """The first sentence of the environment's own documentation, without headings and links."""
        paragraphs = re.split(r"\n\s*\n", re.sub(r"^#.*$", "", inspect.getdoc(self._creator) or "", flags=re.MULTILINE))
        text = next((" ".join(words) for each in paragraphs if (words := each.split())), "")
        return re.split(r"(?<=[.!?])\s", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text), maxsplit=1)[0]

    def options(self) -> tuple[str, ...]:
        """The names of the world's options; those of a base class count if the class passes arguments on to it."""
        return tuple(name for name in self._defaults if name not in FIELDS)

    @cached_property
    def _defaults(self) -> dict[str, Any]:
        """The options with their known defaults."""
        found: dict[str, Any] = {"oracle": None, **dict.fromkeys(_MAKES), **self.spec.kwargs}
        for cls in getattr(self._creator, "__mro__", (self._creator,)):
            if isinstance(cls, type) and "__init__" not in vars(cls):
                continue
            own = list(inspect.signature(cls).parameters.values())
            named = (each for each in own if each.kind not in (each.VAR_KEYWORD, each.VAR_POSITIONAL))
            found |= {each.name: each.default for each in named if each.name not in found}
            if not any(each.kind == each.VAR_KEYWORD for each in own):
                break
        return found

    def turns(self, given: int | None = None, **options: Any) -> int:
        """The given number of turns, limited by the environment's own limit."""
        key = _key(options)
        if key not in self._limits:
            with contextlib.closing(self.make(options)) as env:
                self._limits[key] = limits_of(env)
        return least([*self._limits[key], given])

    def for_lesson(self, settings: Settings) -> "RegisteredLesson":
        """The lesson planned for the options and turns of these settings."""
        return self._lesson(settings.options, settings.max_turns, settings.render_mode is not None)

    def make_world(self, /, **options: Any) -> GymWorld:
        """A world with the planner's knowledge of it."""
        return self._lesson(options).make_world()

    def oracle_class(self) -> Callable[[Callable[[], World[Any, Any, Any]]], Oracle]:
        """A function that makes oracles, with the default options."""
        return self._lesson({}).oracle_class()

    def phrasebook(self, voice: Voice = "plain") -> Phrasebook:
        """The phrases with the default options."""
        return self._lesson({}).phrasebook(voice)

    def make_teacher(
        self, world: World[Any, Any, Any], personality: str | Personality = "oracle", **wording: Unpack[TeacherKeywords]
    ) -> Teacher:
        """A teacher with the plan for this world."""
        model = getattr(world, "model", None)
        planned = (each for each in self._lessons.values() if each.planned is not None and each.planned.model is model)
        return (next(planned, None) or self._lesson({})).make_teacher(world, personality, **wording)

    def make(self, options: Mapping[str, Any], render_mode: str | None = None) -> gymnasium.Env[Any, Any]:
        """The environment.

        Raises:
            ValueError: an option is not allowed; the message has the environment's own error.
            ModuleNotFoundError: the environment needs a package that is not installed.
        """
        given = {name: value for name, value in options.items() if name != "oracle"}
        for name, value in given.items():
            if name in FIELDS:
                raise ValueError(
                    f"{name} is no option of {self.id} but a setting of its lesson, got {name}={value!r}; options that "
                    f"it has: {', '.join(self.options())}"
                )
            if isinstance(self._defaults.get(name), bool) and isinstance(value, str):
                raise ValueError(f"{name} of {self.id} must be true or false, got {value!r}")
        modes = getattr(self._creator, "metadata", {}).get("render_modes") or ()
        shown: dict[str, Any] = {"render_mode": render_mode} if render_mode in modes else {}
        try:
            return gymnasium.make(self.spec, **given, **shown, disable_env_checker=True)
        except gymnasium.error.DependencyNotInstalled as error:
            remedies = [pip_install(extra) for package, extra in _EXTRAS.items() if package in f"{error}"]
            raise ModuleNotFoundError(f"{self.id} cannot be made: {'; run: '.join([f'{error}', *remedies])}") from error
        except Exception as error:  # environments raise errors of many kinds
            said = ", ".join(f"{name}={value!r}" for name, value in given.items()) or "its default options"
            raise ValueError(
                f"{self.id} cannot be made with {said}: {type(error).__name__}: {error}; options that it has: "
                f"{', '.join(self.options())}"
            ) from error

    def _lesson(
        self, options: Mapping[str, Any], max_turns: int | None = None, drawn: bool = False
    ) -> "RegisteredLesson":
        turns = self.turns(max_turns, **options)
        key = f"{_key(options)} {turns} {drawn}"
        lesson = self._lessons.pop(key, None) or RegisteredLesson(self, options, turns, drawn)
        self._lessons[key] = lesson  # the most recently used lesson is last
        while len(self._lessons) > _KEPT:
            del self._lessons[next(iter(self._lessons))]
        return lesson


def _key(options: Mapping[str, Any]) -> str:
    return json.dumps(dict(options), sort_keys=True, default=repr)


class RegisteredLesson(Lesson):
    """The lesson of an environment of Gymnasium's registry with some options.

    Args:
        registered: the environment.
        given: options.
        turns: greatest number of turns of an episode.
        drawn: whether its environments can be rendered.
    """

    def __init__(self, registered: Registered, given: Mapping[str, Any], turns: int, drawn: bool) -> None:
        self.registered, self.given = registered, {**given}
        if given.get("oracle") == REWARDS:  # other teachers try the environment when they plan
            self._check_form()
        self._arguments = registered, self.given, turns, drawn  # as `Registered._lesson` takes them
        oracle = given.get("oracle", "auto")
        if not isinstance(oracle, Planner | str):
            raise ValueError(
                f"oracle must be a planner or its spec string, such as 'exact(gamma=0.95)', got {oracle!r}"
            )
        super().__init__(
            partial(registered.make, self.given, "rgb_array" if drawn else None),
            None if oracle == REWARDS else oracle,
            name=registered.name,
            max_turns=turns,
        )
        self.summary = registered.summary

    def _check_form(self) -> None:
        """Check the form of what the environment returns; the global generators stay as they are."""
        before, of_numpy = shared_draws()
        try:
            with contextlib.closing(self.registered.make(self.given)) as trial:
                found = wrong_form(trial)
        finally:
            random.setstate(before)
            np.random.set_state(of_numpy)  # noqa: NPY002 (only set back)
        if found:
            raise PlanningError(f"{self.registered.id}: {found}")

    def __reduce__(self) -> tuple[Any, ...]:
        return Registered._lesson, self._arguments  # so that another process plans only once

    def __deepcopy__(self, memo: dict[int, Any]) -> "RegisteredLesson":
        return self

    def options(self) -> tuple[str, ...]:
        """The names of the options."""
        return self.registered.options()

    def for_lesson(self, settings: Settings) -> "RegisteredLesson":
        """The lesson of these settings; missing options are as in this lesson."""
        return self.registered.for_lesson(replace(settings, options={**self.given, **settings.options}))

    def make_world(self, /, **options: Any) -> GymWorld:
        """A world; missing options are as in this lesson."""
        if all(name in self.given and same(value, self.given[name]) for name, value in options.items()):
            return super().make_world()
        return self.registered.make_world(**{**self.given, **options})


@cache
def registered(id: str) -> Registered:
    """The environment of an id with the prefix `gym:`; without a version the newest version, with a warning.

    Before the environment's id there may be the module that registers it, as in `gym:package.module:ID`; it is
    imported. The modules of MiniGrid and highway-env are known. Instead of a registered id, the name of a class or a
    function in the module may be given, which makes the environment.

    Raises:
        ValueError: the module cannot be imported, or no environment has this id.
        ModuleNotFoundError: the distribution of a known environment is not installed.
    """
    module, _, name = id.removeprefix(GYM).rpartition(":")
    home = module or next((home for start, home in _HOMES.items() if name.startswith(start)), "")
    if home and (module or name not in gymnasium.registry):
        found = _import(home, id, bool(module))
        if name not in gymnasium.registry and _makes(getattr(found, name, None)):
            return Registered(EnvSpec(name, entry_point=f"{module}:{name}"), module)
    if name not in gymnasium.registry:
        versions = [each for each in gymnasium.registry.values() if each.id.rpartition("-v")[0] == name]
        if not versions:
            raise ValueError(_unknown(id, name))
        newest = max(versions, key=lambda each: each.version or 0)
        warnings.warn(f"{id} stands for {GYM}{newest.id}, its newest version", UserWarning, stacklevel=2)
        name = newest.id
    spec = gymnasium.registry[name]
    if spec.id.startswith(_OURS):
        raise ValueError(f"{id} has a teacher already; leave the prefix {GYM!r} out: {name!r}")
    return Registered(spec, module)


def _makes(value: Any) -> bool:
    """Whether a value of a module is a class of environments, or a function that may make one."""
    return inspect.isfunction(value) or (isinstance(value, type) and issubclass(value, gymnasium.Env))


def _import(module: str, id: str, given: bool) -> ModuleType:
    """Import the module that registers an environment."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if given:
            raise ValueError(
                f"{id}: the module {module!r} cannot be imported: {error}; install it, or mend its name"
            ) from None
        remedy = pip_install(_EXTRAS[module]) if module in _EXTRAS else f"pip install '{module}'"
        raise ModuleNotFoundError(
            f"{id} needs {error.name!r}, which is not installed; run: {remedy}", name=error.name
        ) from error
    except Exception as error:  # a module of the user's own may raise anything
        raise ValueError(f"{id}: the module {module!r} cannot be imported: {error!r}") from error


def _unknown(id: str, name: str) -> str:
    """The message for an id that the registry lacks."""
    base = name.rpartition("-v")[0] or name
    if others := [each for each in gymnasium.registry if each.rpartition("-v")[0] == base]:
        allowed = ", ".join(f"{GYM}{each}" for each in others)
        newest = f", or {GYM}{base} for the newest version" if base != name else ""
        return f"Gymnasium {gymnasium.__version__} has no {name!r}; allowed: {allowed}{newest}"
    module, _, _ = id.removeprefix(GYM).rpartition(":")
    if module:
        return f"{id}: the module {module!r} neither registers nor defines {name!r}; mend the name of one of them"
    for home in dict.fromkeys(_HOMES.values()):
        with contextlib.suppress(ImportError):
            importlib.import_module(home)
    ids = [each for each in gymnasium.registry if not each.startswith(_OURS)]
    near = [f"{GYM}{each}" for each in _nearest(name, ids)]
    said = unknown("environment", id, ids, where="gymnasium.pprint_registry()", near=near)
    return f"{said}; those of another package need the module that registers them, as in '{GYM}package.module:{name}'"


def _nearest(name: str, ids: Iterable[str]) -> list[str]:
    """At most three ids that contain a name, or are spelled nearly like it; of several versions the newest."""
    got = _letters(name)
    newest: dict[str, str] = {}
    for id in sorted(ids, key=lambda id: gymnasium.registry[id].version or 0):
        newest[_letters(id)] = id

    def likeness(letters: str) -> tuple[bool, float]:
        return len(got) > 2 and got in letters, fuzz.ratio(got, letters)

    likely = sorted(sorted(newest), key=likeness, reverse=True)[:_NEAR]  # the sort is stable
    return [newest[each] for each in likely if likeness(each) >= (False, _LIKE)]


def _letters(id: str) -> str:
    """Letters and digits of an id, without its version."""
    return re.sub(r"[\W_]", "", _VERSION.sub("", id)).lower()
