"""Which family serves which personality, for tests that run over both registries."""

from pz_envs.family import all_families
from teachers.personality import PERSONALITIES

FAMILIES = {family.name: family for family in all_families()}
QUICK = [name for name, family in FAMILIES.items() if not family.slow]


def pairs(*more):
    """Names of families and specs of personalities that they serve: all on the shelf, and more.

    Personalities know no family: slow ones are left to the audit and to the cross of options.
    """
    specs = (*PERSONALITIES.names, *more)
    return [(name, spec) for name in QUICK for spec in specs if FAMILIES[name].serves(spec)]
