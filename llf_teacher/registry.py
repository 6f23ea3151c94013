"""The environments by their ids: Gymnasium registration and `make`."""

from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import gymnasium

import pz_envs  # noqa: F401  (registers with PettingZoo)
from pz_envs.family import Family, all_families

if TYPE_CHECKING:
    from llf_teacher.gym_adapter import StudentEnv
    from teachers.personality import Personality
    from teachers.phrasebook import Paraphrase
    from teachers.voice import Voice

PREFIX, ALIAS = "llf-", "verbal-"


class Entry(NamedTuple):
    """One environment."""

    id: str
    """Gymnasium id, as LLF-Bench names it."""
    family: Family
    options: dict[str, Any]
    """The world's options."""


@cache
def entries() -> dict[str, Entry]:
    """Every environment by its id, in sorted order."""
    found = [
        Entry(f"{PREFIX}{name}", family, dict(options))
        for family in all_families()
        for name, options in family.environments.items()
    ]
    return {entry.id: entry for entry in sorted(found, key=lambda entry: entry.id)}


def ids() -> tuple[str, ...]:
    """The ids of every environment."""
    return tuple(entries())


def entry(id: str) -> Entry:
    """The environment of an id or of its alias `verbal-...`.

    Raises:
        ValueError: there is none; the message names the nearest ids.
    """
    name = PREFIX + id.removeprefix(ALIAS) if isinstance(id, str) and id.startswith(ALIAS) else id
    if name not in entries():
        from teachers.spec import unknown

        raise ValueError(unknown("environment", id, ids()))
    return entries()[name]


def register_all() -> None:
    """Enter every environment, its alias and its teacher's side into Gymnasium's registry.

    The environments check the order of calls themselves, so that no wrapper hides their attributes.
    """
    for id, _, _ in entries().values():
        for name in (id, ALIAS + id.removeprefix(PREFIX)):
            gymnasium.register(
                name,
                entry_point="llf_teacher.gym_adapter:StudentEnv",
                kwargs={"env_id": id},
                order_enforce=False,
                disable_env_checker=True,
            )


def make(
    id: str,
    *,
    instruction_type: str = "b",
    feedback_type: str | Iterable[str] = "a",
    teacher: "str | Personality | Any" = "oracle",
    voice: "Voice" = "plain",
    paraphrase: "Paraphrase" = "random",
    visual: bool = False,
    **options: Any,
) -> "StudentEnv":
    """The student's side of an environment, with a teacher in the other seat.

    Args:
        id: an id of `ids()`, or its alias `verbal-...`.
        instruction_type: `b` basic, `p` with hindsight on some tried actions, `c` complete.
        feedback_type: `a` all kinds, `n` none, `m` a random subset each turn, or kinds among r, hp, hn, fp,
            fn, as `"r+hp"`, a set, a list or a tuple.
        teacher: a personality's spec string, a `Personality`, a `Teacher`, or any policy with `reset(rng)` and
            `act(observation, info)` for the teacher's seat.
        voice: the tone: `plain`, `curt`, `socratic`, `warm`, the path of a voice of your own, or a function that
            rewrites a sentence.
        paraphrase: `"random"`, an index or a callable `(templates, **slots) -> str`.
        visual: ask for images where the family has them.
        options: `text`, `max_turns`, `privileged_info`, `render_mode` of `StudentEnv`, and the world's options.

    Raises:
        ValueError: an unknown id, or an argument that is not supported.
    """
    return gymnasium.make(
        entry(id).id,
        instruction_type=instruction_type,
        feedback_type=feedback_type,
        teacher=teacher,
        voice=voice,
        paraphrase=paraphrase,
        visual=visual,
        **options,
    )  # type: ignore[return-value]


def supported_types(id: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The instruction types and the kinds of feedback that an environment supports.

    Raises:
        ValueError: an unknown id.
    """
    oracle = entry(id).family.oracle_class()
    return oracle.instruction_types, tuple(kind.value for kind in oracle.feedback_types)
