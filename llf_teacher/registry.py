"""The registry of environments by their ids, and their registration with Gymnasium."""

import warnings
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import gymnasium
from gymnasium.envs.registration import EnvSpec

import pz_envs  # noqa: F401  (registers with PettingZoo)
from pz_envs.family import Family, all_families, families_to_register, own_families
from pz_envs.settings import Settings
from pz_envs.subject import GYM, Subject

PREFIX, ALIAS, TEACHER = "llf-", "verbal-", "teacher/"


class Entry(NamedTuple):
    """One environment."""

    id: str
    """Gymnasium id, named as in LLF-Bench, or an id of Gymnasium's registry with the prefix `gym:`."""
    family: Subject
    """A family, or for Gymnasium's registry a subject of its own."""
    options: dict[str, Any]
    """Options of the world."""
    sampled: bool
    """Whether it has a golden transcript and is part of the default tests."""


class _Table(NamedTuple):
    entries: dict[str, Entry]
    aliases: dict[str, Entry]


@cache
def _table(search: Callable[[], tuple[Family, ...]]) -> _Table:
    """The environments of the families that `search` finds."""
    families = search()
    found = [
        Entry(f"{PREFIX}{name}", family, dict(options), name in (family.sampled or family.environments))
        for family in families
        for name, options in family.environments.items()
    ]
    entries = {entry.id: entry for entry in sorted(found, key=lambda entry: entry.id)}
    return _Table(
        entries,
        {f"{PREFIX}{alias}": entries[PREFIX + name] for each in families for alias, name in each.aliases.items()},
    )


def entries() -> dict[str, Entry]:
    """Every environment by its id, in sorted order."""
    return _table(all_families).entries


def ids() -> tuple[str, ...]:
    """The ids of every environment."""
    return tuple(entries())


def entry(id: str) -> Entry:
    """The environment of an id, of its alias `verbal-...`, or of another alias, with one warning per process.

    With the prefix `gym:` the id belongs to Gymnasium's registry; its teacher is planned.

    As in Gymnasium, an id without a version means the newest version, with a warning.

    Raises:
        ValueError: an unknown id; the message names the nearest ones.
    """
    if not isinstance(id, str):
        raise ValueError(f"an id must be a string such as {ids()[0]!r}, got {id!r}; `llf list` shows them all")
    if id.startswith(GYM):
        from pz_envs.registered import registered

        subject = registered(id)
        return Entry(subject.id, subject, {}, False)
    name = PREFIX + id.removeprefix(ALIAS) if id.startswith(ALIAS) else id
    for search in (own_families, all_families):  # search other distributions only if necessary
        entries, aliases = _table(search)
        if name in aliases:
            found = aliases[name]
            _warn(f"{name} stands for {found.id}: {getattr(found.family, 'alias_warning', '')}")
            return found
        newest = max((id for id in entries if id.rpartition("-v")[0] == name), key=_version, default=name)
        if newest in entries:
            if newest != name:
                _warn(f"{name} stands for {newest}, its newest version")
            return entries[newest]
    from teachers.spec import unknown

    near = [f"{GYM}{id}"] if id in gymnasium.registry or ":" in id else None
    raise ValueError(unknown("environment", id, ids(), where="`llf list` and llf_teacher.ids()", near=near))


def _version(id: str) -> int:
    return int(id.rpartition("-v")[2])


_SHOWN: set[str] = set()


def _warn(message: str) -> None:
    """Warn once per process, unless the filters of warnings show every warning or none."""
    if message not in _SHOWN:
        kept: dict[Any, Any] = {}
        warnings.warn_explicit(message, UserWarning, "llf_teacher", 1, module=__name__, registry=kept)
        if any(type(key) is tuple for key in kept):  # a filter that shows warnings once has shown it
            _SHOWN.add(message)


def family(name: str) -> Family:
    """The family with a name.

    Raises:
        ValueError: an unknown name; the message names the nearest families.
    """
    families = {each.name: each for each in all_families()}
    if name not in families:
        from teachers.spec import unknown

        raise ValueError(unknown("family", name, families))
    return families[name]


def register_all() -> None:
    """Register every environment, its alias and its teacher's seat with Gymnasium.

    The environments check the order of calls themselves, so that no wrapper hides their attributes.
    """
    entries, aliases = _table(families_to_register)
    for id, each in (entries | aliases).items():
        arrays = bool(each.family.world_batch)
        for name in (id, ALIAS + id.removeprefix(PREFIX)):
            _register(name, "Student", arrays, env_id=id)
    for id, each in entries.items():
        arrays = bool(each.family.world_batch)
        _register(TEACHER + id.removeprefix(PREFIX), "Teacher", arrays, env_id=id, actions="compact")


def _register(name: str, seat: str, arrays: bool, **settings: Any) -> None:
    """Register a seat; `arrays` says whether it has a vector environment."""
    # `gymnasium.register` searches the whole registry twice per call.
    gymnasium.registry[name] = EnvSpec(
        name,
        entry_point=f"llf_teacher.gym:{seat}Env",
        vector_entry_point=f"llf_teacher.gym.vector:{seat}VectorEnv" if arrays else None,
        kwargs=settings,
        order_enforce=False,
        disable_env_checker=True,
    )


def supported_types(id: str, **options: Any) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The instruction types and the kinds of feedback that an environment supports.

    Args:
        id: of the environment.
        options: of its world.

    Raises:
        ValueError: an unknown id, or an option is not allowed.
    """
    found = entry(id)
    settings = Settings.of(id, {**found.options, **options}, found.family.options())
    return types_of(found.family.for_lesson(settings))


def types_of(subject: Subject) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The instruction types and the kinds of feedback that a subject's teachers support."""
    oracle: Any = subject.oracle_class()
    return oracle.instruction_types, tuple(kind.value for kind in oracle.feedback_types)
