"""Movies: recommend something to watch that meets a user's wishes."""

from pz_envs.family import Family

FAMILY = Family(
    name="movies",
    summary="recommend movies or TV shows that meet a user's wishes",
    world="Movies",
    oracle="MoviesOracle",
    environments={"reco-movie-v0": {}},
    showcase=("reco-movie-v0",),
    max_turns=30,
    repeated=True,
    regret_unit="share of unmet requirements",
    reward_only="random_search",
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
