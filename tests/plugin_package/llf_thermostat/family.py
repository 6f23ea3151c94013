"""The declaration, to which the entry point leads. It loads neither the world nor the oracle."""

from pz_envs.family import Family
from pz_envs.learning import StateValues

FAMILY = Family(
    name="thermostat",
    summary="bring a room to the wanted temperature",
    world="llf_thermostat.world:Thermostat",
    oracle="llf_thermostat.oracle:ThermostatOracle",
    phrases="llf_thermostat:phrases.toml",
    environments={"thermostat-v0": {}, "thermostat-Far-v0": {"least": 5, "most": 9}},
    showcase=("thermostat-v0",),
    max_turns=12,
    regret_unit="extra turns of the knob",
    learning=StateValues(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
