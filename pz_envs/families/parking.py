"""Parking: drive a car into a marked spot."""

from pz_envs.family import Family
from pz_envs.learning import Trend

FAMILY = Family(
    name="parking",
    summary="drive a car into a marked spot, nose first",
    world="Parking",
    oracle="ParkingOracle",
    picture="ParkingPicture",
    environments={"highway-parking-v0": {}},
    showcase=("highway-parking-v0",),
    max_turns=100,
    rules=2,
    regret_unit="turns lost",
    learning=Trend(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
