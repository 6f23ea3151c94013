"""A door with a lock of two dials."""

from pz_envs.family import Family

FAMILY = Family(
    name="door",
    summary="find the setting of two dials that opens a door",
    world="Door",
    oracle="DoorOracle",
    environments={"door-v0": {}},
    showcase=("door-v0",),
    max_cycles=8,
    regret_unit="turns before a shut door",
    reward_only="random",
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
