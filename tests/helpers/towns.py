"""The environments whose worlds may share the law of a town, and the options that towns need."""

from sampling import ENTRIES


def towns_of(entry):
    """Whether an environment has towns; problems with given arms have none."""
    able = "town" in entry.family.options() if not entry.family.missing() else False
    return able and not (entry.family.name == "bandits" and entry.family.make_world(**entry.options).problem.fixed)


TOWNS = [each for each in ENTRIES if towns_of(each.values[0])]
"""Every environment with towns; those that the default tests leave out are marked `full`."""
