"""Gridworld: find the treasure in a house of rooms."""

from pz_envs.family import Family
from pz_envs.learning import StateValues

FAMILY = Family(
    name="gridworld",
    summary="find the treasure in a house of rooms",
    world="Gridworld",
    oracle="GridworldOracle",
    world_batch="GridworldBatch",
    oracle_batch="GridworldOracleBatch",
    picture="GridworldPicture",
    posterior="GridworldPosterior",
    environments={"gridworld-v0": {}},
    showcase=("gridworld-v0",),
    max_turns=20,
    rules=2,
    regret_unit="moves wasted",
    learning=StateValues(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
