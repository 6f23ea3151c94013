"""The environments by their ids, and their registration with Gymnasium."""

import warnings
from functools import cache
from typing import Any, NamedTuple

import gymnasium

import pz_envs  # noqa: F401  (registers with PettingZoo)
from pz_envs.family import Family, all_families

PREFIX, ALIAS = "llf-", "verbal-"


class Entry(NamedTuple):
    """One environment."""

    id: str
    """Gymnasium id, as LLF-Bench names it."""
    family: Family
    options: dict[str, Any]
    """The world's options."""
    sampled: bool
    """Whether there is a golden transcript of it, and the default tests play it."""


@cache
def entries() -> dict[str, Entry]:
    """Every environment by its id, in sorted order."""
    found = [
        Entry(f"{PREFIX}{name}", family, dict(options), name in (family.sampled or family.environments))
        for family in all_families()
        for name, options in family.environments.items()
    ]
    return {entry.id: entry for entry in sorted(found, key=lambda entry: entry.id)}


@cache
def _aliases() -> dict[str, Entry]:
    """What further names stand for."""
    return {
        f"{PREFIX}{alias}": entries()[PREFIX + name]
        for family in all_families()
        for alias, name in family.aliases.items()
    }


def ids() -> tuple[str, ...]:
    """The ids of every environment."""
    return tuple(entries())


def entry(id: str) -> Entry:
    """The environment of an id, of its alias `verbal-...`, or of another alias, which is warned of once a process.

    Raises:
        ValueError: there is none; the message names the nearest ids.
    """
    if not isinstance(id, str):
        raise ValueError(f"an id must be a string such as {ids()[0]!r}, got {id!r}; `llf list` shows them all")
    name = PREFIX + id.removeprefix(ALIAS) if id.startswith(ALIAS) else id
    if name in _aliases():
        found = _aliases()[name]
        _warn(f"{name} stands for {found.id}: {found.family.alias_warning}")
        return found
    if name not in entries():
        from teachers.spec import unknown

        raise ValueError(unknown("environment", id, ids()))
    return entries()[name]


_SHOWN: set[str] = set()


def _warn(message: str) -> None:
    """Warn once a process; whoever filters warnings so as to see all of them, or none, gets that."""
    if message not in _SHOWN:
        kept: dict[Any, Any] = {}
        warnings.warn_explicit(message, UserWarning, "llf_teacher", 1, module=__name__, registry=kept)
        if any(type(key) is tuple for key in kept):  # a filter that shows things once has shown it
            _SHOWN.add(message)


def family(name: str) -> Family:
    """The family of a name.

    Raises:
        ValueError: there is none; the message names the nearest families.
    """
    families = {each.name: each for each in all_families()}
    if name not in families:
        from teachers.spec import unknown

        raise ValueError(unknown("family", name, families))
    return families[name]


def register_all() -> None:
    """Enter every environment, its alias and its teacher's side into Gymnasium's registry.

    The environments check the order of calls themselves, so that no wrapper hides their attributes.
    """
    for id, each in (entries() | _aliases()).items():
        for name in (id, ALIAS + id.removeprefix(PREFIX)):
            gymnasium.register(
                name,
                entry_point="llf_teacher.gym:StudentEnv",
                vector_entry_point="llf_teacher.gym.vector:StudentVectorEnv" if each.family.world_batch else None,
                kwargs={"env_id": id},
                order_enforce=False,
                disable_env_checker=True,
            )


def supported_types(id: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The instruction types and the kinds of feedback that an environment supports.

    Raises:
        ValueError: an unknown id.
    """
    oracle = entry(id).family.oracle_class()
    return oracle.instruction_types, tuple(kind.value for kind in oracle.feedback_types)
