"""The gallery of personalities: for each an episode in which it differs from the oracle."""

import dataclasses
import sys
from collections.abc import Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import StudentEnv
from llf_teacher.registry import PREFIX
from llf_teacher.tools.markdown import escape, table
from pz_envs.family import Family, own_families
from pz_envs.learning import StateValues
from teachers.personality import PERSONALITIES

__all__ = ["gallery", "gallery_entry"]

_SEEDS, _TURNS, _SHOWN = range(30), 12, 4
_INSTEAD = {
    "only": "only(kinds='fp')",
    "mistake": "mistake(eps=0.5)",
    "drifting": "drifting(after=2)",
    "myopic": "myopic(gamma=0.5)",
}
"""Specs to show for personalities that rarely differ from the oracle with their default parameters."""


class _Reply(NamedTuple):
    """Feedback after an action."""

    action: str
    text: str


def gallery() -> str:
    """The page as Markdown."""
    return (
        "# Gallery of personalities\n\nEach beside the `oracle`, in the same world, after the same actions of a "
        "student that acts at random: an episode in which they differ, from the first turn in which they do. "
        "[Personalities and voices](../personalities.md) defines them and says how they compose.\n\n"
        + "\n".join(gallery_entry(name) for name in PERSONALITIES.names if name != "oracle")
    )


def gallery_entry(name: str) -> str:
    """The section of a personality."""
    cls: Any = PERSONALITIES[name]
    spec = _INSTEAD.get(name, name)
    parameters = ", ".join(f"{field.name}={field.default!r}" for field in dataclasses.fields(cls))
    _, _, definition = (sys.modules[cls.__module__].__doc__ or "").partition("\n")[0].partition(": ")
    honest = "honest" if cls().honest else "not honest"
    head = f"## {name}\n\n`{name}({parameters})`" if parameters else f"## {name}\n\n`{name}`"
    return f"{head}: {escape(definition)} Source: {escape(cls.source)}; {honest}.\n\n{_difference(spec)}"


def _difference(spec: str) -> str:
    """A few turns of an episode, from the first turn in which a personality differs from the oracle.

    Raises:
        ValueError: there is no such turn in the episodes that are tried.
    """
    families = sorted((each for each in own_families() if not each.slow and not each.missing()), key=_order)
    for family, seed in product((each for each in families if each.serves(spec)), _SEEDS):
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
