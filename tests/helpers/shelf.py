"""Which family serves which personality, for tests that run over both registries."""

import numpy as np

from pz_envs.family import all_families
from teachers.atoms import KINDS
from teachers.oracle import Oracle
from teachers.personality import PERSONALITIES

FAMILIES = {family.name: family for family in all_families()}
LASTING = 10  # turns
TYPES = Oracle.instruction_types
QUICK = [name for name, family in FAMILIES.items() if not family.slow]


def is_rich(family):
    """Whether a family has all that can be taught, and random play lasts: for what takes many claims to see."""
    oracle, world = family.oracle_class(), family.make_world(**family.environments[family.showcase[0]])
    if oracle.feedback_types != KINDS or oracle.instruction_types != TYPES:
        return False
    rng = np.random.default_rng(0)
    for _ in range(5):
        world.reset(seed=int(rng.integers(2**31)))
        if any(any(world.step(world.sample_action(rng))[2:4]) for _ in range(min(family.max_turns, LASTING) - 1)):
            return False
    return True


RICH = [name for name in QUICK if is_rich(FAMILIES[name])]


def pairs(*more):
    """Names of families and specs of personalities that they serve: all on the shelf, and more.

    Personalities know no family: slow ones are left to the audit and to the cross of options.
    """
    specs = (*PERSONALITIES.names, *more)
    return [(name, spec) for name in QUICK for spec in specs if FAMILIES[name].serves(spec)]
