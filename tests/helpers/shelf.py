"""Which family serves which personality, for tests that run over both registries."""

import dataclasses

import numpy as np

from pz_envs.family import all_families
from teachers.atoms import KINDS
from teachers.oracle import Oracle
from teachers.personality import PERSONALITIES

FAMILIES = {family.name: family for family in all_families()}
LASTING = 10  # turns
QUICK = [name for name, family in FAMILIES.items() if not family.slow]


def is_complete(family):
    """Whether all kinds of feedback and all types of instructions are given."""
    oracle = family.oracle_class()
    return oracle.feedback_types == KINDS and oracle.instruction_types == Oracle.instruction_types


def is_rich(family):
    """Whether a family is complete, and random play lasts: for what takes many claims to see."""
    if not is_complete(family):
        return False
    world = family.make_world(**family.environments[family.showcase[0]])
    rng = np.random.default_rng(0)
    for _ in range(5):
        world.reset(seed=int(rng.integers(2**31)))
        if any(any(world.step(world.sample_action(rng))[2:4]) for _ in range(min(family.max_turns, LASTING) - 1)):
            return False
    return True


COMPLETE = [name for name, family in FAMILIES.items() if is_complete(family)]
RICH = [name for name in QUICK if is_rich(FAMILIES[name])]


def few_worlds(name):
    """The spec of a personality, with few worlds if it draws some."""
    return (
        f"{name}(worlds=8)" if "worlds" in {field.name for field in dataclasses.fields(PERSONALITIES[name])} else name
    )


def light(name):
    """The same, but with all worlds if these are all that it knows."""
    return name if PERSONALITIES[name]().evidence else few_worlds(name)


def pairs(*more, names=QUICK):
    """Names of families and specs of personalities that they serve: all on the shelf, and more.

    Personalities know no family: slow ones are left to the audit and to the cross of options.
    """
    specs = (*map(light, PERSONALITIES.names), *more)
    return [(name, spec) for name in names for spec in specs if FAMILIES[name].serves(spec)]
