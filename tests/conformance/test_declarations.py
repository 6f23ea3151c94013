"""The kit for declarations accepts every family, and finds each thing that a declaration misnames."""

from dataclasses import replace

import gymnasium
import pytest

import llf_teacher
from pz_envs.family import all_families
from pz_envs.learning import KINDS, Lines, Smooth
from pz_envs.testing import check_family

FAMILY = next(family for family in all_families() if not family.repeated)
(NAME, OPTIONS), *_ = FAMILY.environments.items()


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_what_a_family_declares_is_there(family):
    check_family(family)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"world": "Wrold"}, f"declares {NAME}, which fails to load: AttributeError"),
        ({"world": "pathlib:Path"}, "pathlib:Path is no World"),
        ({"oracle": "worlds.wrold:Oracle"}, "declares oracle, which fails to load: ModuleNotFoundError"),
        ({"oracle": "pathlib:Path"}, "pathlib:Path is no Oracle"),
        ({"phrases": "teachers.phrases:none.toml"}, "declares phrases, which fails to load"),
        ({"environments": {NAME: {"no_such_option": 1}}}, f"declares {NAME}, which fails to load: ValueError"),
        ({"environments": {}, "showcase": ()}, "has no environments, or no showcase"),
        ({"showcase": ("typo-v0",)}, "names environments that it does not have: typo-v0"),
        ({"sampled": ("typo-v0",)}, "names environments that it does not have: typo-v0"),
        ({"aliases": {"other-v0": "typo-v0"}}, "names environments that it does not have: typo-v0"),
        ({"aliases": {NAME: NAME}}, f"has environments with the names of aliases: {NAME}"),
        ({"extra": "wrold"}, "llf-teacher has no extra 'wrold'; it has "),
        ({"module": "pz_envs.family"}, "pz_envs.family lacks env, raw_env, parallel_env"),
    ],
)
def test_what_is_not_there_is_found(changes, message):
    with pytest.raises(AssertionError, match=message):
        check_family(replace(FAMILY, **changes))


@pytest.mark.parametrize("name", ["llf-guess-v0", "llf/guess-v0", "verbal-guess-v0"])
def test_names_are_without_the_prefix_of_ids(name):
    prefix = name.removesuffix("guess-v0")
    with pytest.raises(ValueError, match=f"names are without the prefix '{prefix}', .*: 'guess-v0'"):
        replace(FAMILY, environments={name: {}}, showcase=(name,))
    with pytest.raises(ValueError, match=f"names are without the prefix '{prefix}'"):
        replace(FAMILY, aliases={name: NAME})


@pytest.mark.parametrize("learning", ["q_learning", None, KINDS[0], object()])
def test_what_rewards_teach_is_one_of_the_known_facts(learning):
    message = r"learning must be one of pz_envs\.learning: .*; got "
    with pytest.raises(ValueError, match=message):
        replace(FAMILY, learning=learning)
    with pytest.raises(ValueError, match=message):
        llf_teacher.Lesson(gymnasium.make("CartPole-v1"), learning=learning)


def test_the_facts_are_checked():
    with pytest.raises(ValueError, match="size must be a number from 0 to 1, got 2"):
        Smooth(size=2)
    with pytest.raises(ValueError, match=r"syllables must be a tuple of positive integers, got \(\)"):
        Lines(lengths=(3,), syllables=())
