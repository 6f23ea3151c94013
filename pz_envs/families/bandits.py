"""Bandits: pull the arm that pays most."""

from pz_envs.family import Family
from pz_envs.learning import ActionValues

FAMILY = Family(
    name="bandits",
    summary="pull the arm that pays most on average",
    world="Bandit",
    oracle="BanditOracle",
    picture="BanditPicture",
    posterior="BanditPosterior",
    world_batch="BanditBatch",
    oracle_batch="BanditOracleBatch",
    environments={
        f"bandits-Bandit{problem}-v0": {"problem": problem}
        for problem in (
            "TenArmedGaussian",
            "TenArmedRandomFixed",
            "TenArmedRandomRandom",
            "TenArmedUniformDistributedReward",
            "TwoArmedDeterministicFixed",
            "TwoArmedHighHighFixed",
            "TwoArmedHighLowFixed",
            "TwoArmedLowLowFixed",
        )
    },
    showcase=("bandits-BanditTenArmedRandomFixed-v0",),
    max_turns=30,
    repeated=True,
    rules=2,
    regret_unit="expected reward lost",
    learning=ActionValues(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
