"""Poems: write verse with the right number of lines and syllables."""

from pz_envs.family import Family
from pz_envs.learning import Lines

FAMILY = Family(
    name="poem",
    summary="write verse with the right number of lines and syllables",
    world="Poem",
    oracle="PoemOracle",
    picture="PoemPicture",
    environments={
        f"poem-{form}-v0": {"form": form}
        for form in ("Haiku", "LineSyllableConstrainedPoem", "SyllableConstrainedPoem", "Tanka")
    },
    showcase=("poem-Haiku-v0",),
    max_turns=30,
    repeated=True,
    regret_unit="share of wrong lines",
    learning=Lines(lengths=(3, 5, 4, 14, 15, 19), syllables=(5, 7, 8, 9, 10, 17)),
)
env, raw_env, parallel_env = FAMILY.env, FAMILY.raw_env, FAMILY.parallel_env
