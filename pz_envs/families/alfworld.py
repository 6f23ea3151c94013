"""ALFWorld: household tasks in text."""

from pz_envs.family import Family
from pz_envs.learning import NoRewards

FAMILY = Family(
    name="alfworld",
    summary="do household tasks by text commands",
    world="Alfworld",
    oracle="AlfworldOracle",
    picture="AlfworldPicture",
    environments={"alfworld-v0": {}},
    showcase=("alfworld-v0",),
    max_turns=100,
    regret_unit="commands wasted",
    learning=NoRewards(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
