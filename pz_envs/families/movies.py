"""Movies: recommend something to watch that meets a user's wishes."""

from pz_envs.family import Family
from pz_envs.learning import BestAnswer

FAMILY = Family(
    name="movies",
    summary="recommend movies or TV shows that meet a user's wishes",
    world="Movies",
    oracle="MoviesOracle",
    picture="MoviesPicture",
    posterior="MoviesPosterior",
    environments={"reco-movie-v0": {}},
    showcase=("reco-movie-v0",),
    max_turns=30,
    repeated=True,
    rules=2,
    regret_unit="share of titles that do not meet every wish",
    learning=BestAnswer(),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
