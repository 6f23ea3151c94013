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


def lightest(name):
    """The spec of a personality, with few worlds if it draws some: for what does not depend on what is true."""
    draws = any(field.name == "worlds" for field in dataclasses.fields(PERSONALITIES[name]))
    return f"{name}(worlds=8)" if draws else name


def light(name):
    """The spec of a personality, with few worlds if it draws some; not if these are all that it knows."""
    return name if PERSONALITIES[name]().evidence else lightest(name)


def pairs(*more, names=QUICK, spec=light):
    """Names of families and specs of personalities that they serve: all on the shelf, each by `spec`, and more.

    Personalities know no family: slow ones are left to the audit and to the cross of options.
    """
    specs = (*map(spec, PERSONALITIES.names), *more)
    return [(name, spec) for name in names for spec in specs if FAMILIES[name].serves(spec)]
