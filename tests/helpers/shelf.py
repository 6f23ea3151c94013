"""Which family serves which personality, for tests that run over both registries."""

from pz_envs.family import all_families
from teachers.personality import PERSONALITIES

FAMILIES = {family.name: family for family in all_families()}


def pairs(*more):
    """Names of families and specs of personalities that they serve: all on the shelf, and more."""
    specs = (*PERSONALITIES.names, *more)
    return [(name, spec) for name, family in FAMILIES.items() for spec in specs if family.serves(spec)]
