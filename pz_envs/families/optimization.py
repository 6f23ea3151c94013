"""Optimization: find the point of least loss."""

from pz_envs.family import Family
from pz_envs.learning import Smooth

FAMILY = Family(
    name="optimization",
    summary="find the point of least loss",
    world="Optimization",
    oracle="OptimizationOracle",
    picture="OptimizationPicture",
    world_batch="OptimizationBatch",
    oracle_batch="OptimizationOracleBatch",
    environments={
        f"optimization-{loss}-v0": {"loss": loss}
        for loss in (
            "Bohachevsky",
            "Booth",
            "Matyas",
            "McCormick",
            "Rosenbrock",
            "RotatedHyperEllipsoid",
            "SixHumpCamel",
            "ThreeHumpCamel",
        )
    },
    showcase=("optimization-Booth-v0",),
    max_turns=10,
    rules=2,
    regret_unit="reward lost",
    learning=Smooth(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
