"""PettingZoo environments in which a teacher and a student take turns over a world.

Importing this package registers `llf/<name>` for every environment of every family with PettingZoo.
"""

from pz_envs.family import first_families

for _family in first_families():
    _family.register()
