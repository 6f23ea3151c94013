"""The classroom: what may be asked of it, and what is refused."""

import numpy as np
import pytest
from playing import Fixed

from pz_envs.family import all_families
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import Attention
from pz_envs.seats import TEACHER
from pz_envs.testing import require_parallel

GRID = next(family for family in all_families() if family.name == "gridworld")
ALL = 31


def test_the_teachers_seat_alone():
    def make():
        aec = GRID.raw_env(seating="classroom", students=2, attention=2, max_cycles=3)
        return ParallelSeats(aec, {student: Fixed(0) for student in aec.students})

    require_parallel(make)
    env = make()
    observations, _ = env.reset(seed=0)
    steps = 0
    while env.agents:
        action = int(np.flatnonzero(observations[TEACHER]["action_mask"])[-1])
        observations, rewards, _, truncations, _ = env.step({TEACHER: action})
        assert set(rewards) == {TEACHER}
        steps += 1
    assert steps == 8
    assert truncations == {TEACHER: True}


@pytest.mark.parametrize(
    ("partners", "match"),
    [
        ({"student_9": Fixed(0)}, "there is no agent 'student_9'; allowed: teacher_0, student_0"),
        ({TEACHER: Fixed(0), "student_0": Fixed(0)}, "partners play every agent"),
    ],
)
def test_seats_of_partners(partners, match):
    with pytest.raises(ValueError, match=match):
        ParallelSeats(GRID.raw_env(), partners)


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"students": 0}, "students must be an integer from 1 to 64, got 0"),
        ({"students": 65}, "students must be an integer from 1 to 64, got 65"),
        ({"students": "3"}, "students must be an integer from 1 to 64, got '3'"),
        ({"students": True}, "students must be an integer from 1 to 64, got True"),
        ({"attention": 9}, "attention must be an integer from 1 to 8, the number of students, got 9"),
        ({"attention": 0}, "attention must be an integer from 1 to 8"),
        ({"attention": True}, "attention must be an integer from 1 to 8, the number of students, got True"),
        ({"attention_cost": "x"}, "attention_cost must be a finite number of at least 0, got 'x'"),
        ({"teacher_reward": "gold"}, "unknown teacher_reward 'gold'; .*student_reward"),
    ],
)
def test_bad_arguments(settings, match):
    with pytest.raises(ValueError, match=match):
        GRID.raw_env(seating="classroom", **settings)


def test_numbers_may_be_numpys():
    env = GRID.raw_env(
        seating="classroom",
        students=np.int64(2),
        attention=np.int64(2),
        cost=np.float32(0.5),
        attention_cost=np.int64(1),
        budget=np.int64(1),
    )
    env.reset(seed=0)
    env.step(env.address(0, ALL))
    assert env.rewards[TEACHER] == -1.5
    assert env.observe(TEACHER) in env.observation_space(TEACHER)


@pytest.mark.parametrize(
    ("speech", "action"), [("kinds", 249), ("kinds", -1), ("message", {"student": 1}), ("message", "x")]
)
def test_other_actions_of_the_teacher_are_refused(speech, action):
    env = GRID.raw_env(seating="classroom", speech=speech)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the teacher's action must be"):
        env.step(action)
    assert env.agent_selection == TEACHER


def test_unknown_rule():
    with pytest.raises(ValueError, match=r"unknown rule 'loudest'; .*round_robin"):
        Attention("loudest")
