"""A door with a lock of two dials."""

from pz_envs.family import Family
from pz_envs.learning import NoRewards

FAMILY = Family(
    name="door",
    summary="find the setting of two dials that opens a door",
    world="Door",
    oracle="DoorOracle",
    environments={"door-v0": {}},
    showcase=("door-v0",),
    max_turns=8,
    regret_unit="turns before a shut door",
    learning=NoRewards(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
