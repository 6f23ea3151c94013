"""The gallery of personalities: for each an episode in which it differs from the oracle."""

import dataclasses
import sys
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import PREFIX
from llf_teacher.tools.film import film, save
from llf_teacher.tools.markdown import escape, table
from pz_envs.family import Family, own_families
from pz_envs.learning import StateValues
from teachers.personality import PERSONALITIES

__all__ = ["LESSONS", "gallery", "gallery_entry", "write_lesson"]

_SEEDS, _TURNS, _SHOWN = range(30), 12, 4
_INSTEAD = {
    "only": "only(kinds='fp')",
    "mistake": "mistake(eps=0.5)",
    "drifting": "drifting(after=2)",
    "myopic": "myopic(gamma=0.5)",
    "overconfident": "partial(worlds=64) | overconfident",
    "timid": "partial(worlds=64) | timid",
}
"""Specs to show for personalities that rarely differ from the oracle with their default parameters."""


LESSONS = {
    "oracle": "Says all that is true",
    "mistake(eps=0.5)": "Is wrong every other time",
    "delayed(turns=2)": "Says it two turns late",
    "hinter": "Hints first, and advises if that did not help",
    "verification": "Right or wrong, and no reason",
    "sycophant": "Praises whether deserved or not",
    "worked_example(n=3)": "Shows the next moves at once",
    "retry_only": "Says nothing but: try again",
}
"""Personalities to film in the same lesson, with a description."""


class _Reply(NamedTuple):
    """Feedback after an action."""

    action: str
    text: str


def gallery(films: Sequence[str] = ()) -> str:
    """The page as Markdown.

    Args:
        films: paths of films of `LESSONS`, relative to the page, in their order; they are not shown if it is empty.
    """
    shown = "".join(
        f"### {meaning}\n\n`{spec}`\n\n![A lesson by {spec}]({film})\n\n"
        for (spec, meaning), film in zip(LESSONS.items(), films, strict=bool(films))
    )
    lessons = (
        "## One lesson, several teachers\n\nThe same house and a student that does as it is told; each sentence is "
        f"marked as true or false.\n\n{shown}"
    )
    return (
        f"# Gallery of personalities\n\n{lessons if films else ''}## Every personality\n\n"
        "Each beside the `oracle`, in the same world, after the same actions of a student that acts at random: an "
        "episode in which they differ, from the first turn in which they do. [Teachers](teachers.md) says how they "
        "combine.\n\n" + "\n".join(gallery_entry(name) for name in PERSONALITIES.names if name != "oracle")
    )


def write_lesson(spec: str, path: Path) -> None:
    """Write a film of a lesson under one personality: the same world and the same student for all `LESSONS`."""
    id = f"{PREFIX}{_quick_families()[0].showcase[0]}"
    frames = film(id, student="obedient", seed=1, teacher=spec, privileged_info=True, max_turns=7)
    save(frames, path, 1.2)


def gallery_entry(name: str) -> str:
    """The section of a personality."""
    cls: Any = PERSONALITIES[name]
    spec = _INSTEAD.get(name, name)
    parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
    _, _, definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")
    honest = "honest" if cls().honest else "not honest"
    head = f"### {name}\n\n`{name}({parameters})`" if parameters else f"### {name}\n\n`{name}`"
    return f"{head}: {escape(definition)} Source: {escape(cls.source)}; {honest}.\n\n{_difference(spec)}"


def _difference(spec: str) -> str:
    """A few turns of an episode, from the first turn in which a personality differs from the oracle.

    Raises:
        ValueError: the tried episodes have no such turn.
    """
    for family, seed in product((each for each in _quick_families() if each.serves(spec)), _SEEDS):
        turns = list(zip(_episode(family, "oracle", seed), _episode(family, spec, seed), strict=True))
        first = next((i for i, (plain, own) in enumerate(turns) if plain.text != own.text), None)
        if first is not None:
            rows = [
                (
                    f"{i}",
                    f"`{plain.action}`" if plain.action else "",
                    escape(plain.text),
                    escape(own.text) or "(nothing)",
                )
                for i, (plain, own) in list(enumerate(turns))[first : first + _SHOWN]
            ]
            shown = table(("turn", "action", "`oracle`", f"`{spec}`"), rows)
            return f"`{PREFIX}{family.showcase[0]}`, seed {seed}:\n\n{shown}"
    raise ValueError(
        f"{spec} does not differ from the oracle in any episode that was tried; give it other parameters in _INSTEAD"
    )


def _quick_families() -> list[Family]:
    """The installed families with quick worlds, the clearest examples of personalities first."""
    return sorted((each for each in own_families() if not each.slow and not each.missing()), key=_order)


def _order(family: Family) -> tuple[bool, str]:
    """Families with states and few actions come first, because they show most personalities clearly."""
    return not isinstance(family.learning, StateValues), family.name


def _episode(family: Family, spec: str, seed: int) -> Iterator[_Reply]:
    """The feedback at the opening and in each turn; the actions depend on the seed only."""
    env = StudentEnv(f"{PREFIX}{family.showcase[0]}", teacher=spec, paraphrase=0, max_turns=_TURNS)
    rng = np.random.default_rng(seed)
    observation, _ = env.reset(seed=seed)
    yield _Reply("", f"{observation['feedback']}")
    over = False
    while not over:
        action = env.session.world.sample_action(rng)
        observation, _, terminated, truncated, _ = env.step(action)
        over = terminated or truncated
        yield _Reply(f"{env.session.moment.action}", f"{observation['feedback']}")
    env.close()
