"""The same seed and spec give the same bytes: in another process, under another hash seed, interleaved."""

import hashlib
import os
import random
import subprocess
import sys
from functools import cache

import numpy as np
import pytest
from design import amount
from playing import steps
from sampling import practice

import llf_teacher
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.registry import PREFIX, entry
from llf_teacher.studies.execution.episode import play
from llf_teacher.tools.golden import transcript
from pz_envs.family import all_families
from worlds.testing import plain

SHOWCASE = [PREFIX + family.showcase[0] for family in all_families()]
TEACHERS = (
    "oracle",
    "mix",
    "mistake(eps=0.5) | delayed(turns=1)",
    "placebo",
    "misaligned",
    "feature_noise(high=1) | limited_knowledge | vague",
)
WHOLE = amount(False, full=True)


def digest(whole):
    """A digest of many episodes, with all that was said and done; whole: by each student, else by one in turn."""
    students = ("random", "text_only", "reward_only")
    records = [
        play(EpisodeSpec(id, teacher, student, practice(entry(id).family), "a", 8, 4, ""))
        for id in SHOWCASE
        for number, teacher in enumerate(filter(entry(id).family.serves, TEACHERS))
        for student in (students if whole else students[number % 3 :][:1])
    ]
    return hashlib.sha256(repr(records).encode()).hexdigest()


@cache
def expected():
    """The digest here, and whether the global generators are as they were before."""
    before = random.getstate(), plain(np.random.get_state())  # noqa: NPY002
    found = digest(WHOLE)
    return found, (random.getstate(), plain(np.random.get_state())) == before  # noqa: NPY002


@pytest.mark.parametrize("hash_seed", [pytest.param("0", marks=pytest.mark.full), "4242"])
def test_another_process_and_another_hash_seed(hash_seed):
    program = f"import runpy; print(runpy.run_path({__file__!r})['digest']({WHOLE}))"
    environment = os.environ | {"PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)}
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=True
    )
    assert result.stdout.strip() == expected()[0]


@pytest.mark.parametrize("id", SHOWCASE)
def test_environments_do_not_disturb_each_other(id):
    def make():
        env = llf_teacher.make(id, teacher="mix")
        return env, [env.reset(seed=1)[0]["feedback"]]

    (alone, expected), (one, first), (two, second) = make(), make(), make()
    action = alone.session.world.sample_action(np.random.default_rng(0))
    expected += [observation["feedback"] for observation, *_ in steps(alone, [action] * 8)]
    for (mine, *_), (yours, *_) in zip(steps(one, [action] * 8), steps(two, [action] * 8), strict=True):
        first.append(mine["feedback"])
        second.append(yours["feedback"])
    assert first == second == expected


def test_transcripts_repeat():
    assert [transcript(id) for id in SHOWCASE] == [transcript(id) for id in SHOWCASE]


def test_no_global_generator_is_touched():
    """Neither by worlds nor by teachers, students or phrases."""
    assert expected()[1]
