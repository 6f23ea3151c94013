"""PettingZoo environments in which a teacher and a student take turns over a world.

Importing this package registers `llf/<name>` for every environment of every family with PettingZoo.
"""

from pz_envs.family import families_to_register

for _family in families_to_register():
    _family.register()
