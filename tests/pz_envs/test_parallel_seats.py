"""Policies in some seats, the others in parallel: what partners see, when they hear, and what cannot be."""

import copy

import numpy as np
import pytest
from gymnasium import spaces
from shelf import QUICK

from llf_teacher.students.parsing import parse_student
from pz_envs.family import all_families
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.seats import STUDENT, TEACHER
from teachers.feedback import SUBSETS
from worlds.testing import plain

FAMILIES = {family.name: family for family in all_families()}
GRID = FAMILIES["gridworld"]


def played(family, specs, seating="tutoring", seed=0, **settings):
    """The students' policies and their returns when a teacher that is left says everything."""
    aec = family.raw_env(seating=seating, speech="kinds", **settings)
    seats = [agent for agent in aec.possible_agents if agent != TEACHER]
    partners = {
        agent: parse_student(spec).seat(family, aec.session.world) for agent, spec in zip(seats, specs, strict=True)
    }
    env = ParallelSeats(aec, partners)
    observations, _ = env.reset(seed=seed)
    while env.agents:
        mask = observations[TEACHER]["action_mask"]
        observations, *_ = env.step({TEACHER: int(np.flatnonzero(mask)[-1])})
    return partners, [aec.moment_of(agent).success for agent in seats]


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("spec", ["reward_only", "oracle", "obedient", "random"])
def test_every_student_is_a_partner(name, spec):
    played(FAMILIES[name], [spec], max_cycles=5)


def test_who_weighs_advice_is_a_partner():
    played(GRID, ["bayesian"], max_cycles=5)


def test_who_is_told_the_truth_succeeds():
    assert [played(GRID, ["oracle"], seed=seed)[1] for seed in range(10)] == [[True]] * 10


def test_who_hears_before_it_acts_succeeds():
    assert [played(GRID, ["obedient"], seed=seed)[1] for seed in range(10)] == [[True]] * 10


def test_everybody_in_a_class_is_told_of_itself():
    class Listener:
        reads = "truth"

        def reset(self, rng):
            self.last = None

        def act(self, observation, info):
            assert info["moment"].action == self.last
            self.last = self.action
            return self.action

    listeners = [Listener() for _ in range(3)]
    for action, each in enumerate(listeners):
        each.action = action
    aec = GRID.raw_env(seating="classroom", students=3, attention=3, max_cycles=6)
    env = ParallelSeats(aec, dict(zip(aec.students, listeners, strict=True)))
    env.reset(seed=1)
    while env.agents:
        env.step({TEACHER: 0})


def test_a_learner_is_told_that_an_episode_has_ended():
    """`finish` brings in the last reward, which no further turn would."""
    told = []

    class Learner:
        reads = "reward"

        def reset(self, rng):
            """Nothing to forget."""

        def act(self, observation, info):
            told.append(info["reward"])
            return 0

        def finish(self, observation, info, terminated):
            told.append((info["reward"], terminated))

    aec = GRID.raw_env(speech="kinds", max_cycles=3)
    env = ParallelSeats(aec, {STUDENT: Learner()})
    env.reset(seed=0)
    while env.agents:
        env.step({TEACHER: SUBSETS - 1})
    assert told == [0.0, 0.0, 0.0, (0.0, False)]


CLASS = {"seating": "classroom", "students": 3, "attention": 3, "speech": "kinds"}
ROUNDS = {
    "students": CLASS,
    "students that may ask": {**CLASS, "ask_cost": 0.1},
    "students in lifetimes": {**CLASS, "episodes": 2},
    "teachers": {"seating": "panel", "teachers": ["oracle", "oracle"], "speech": "kinds"},
    "teachers in words": {"seating": "panel", "teachers": ["oracle", "oracle"], "speech": "message"},
}
"""Rounds in which several agents act."""


class Always:
    """A policy for any seat."""

    def __init__(self, action):
        self.action = action

    def reset(self, rng):
        """Nothing to forget."""

    def act(self, observation, info):
        return self.action


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("round", ROUNDS)
def test_an_action_outside_its_space_changes_nothing_for_any_agent(name, round):
    """The other agents, whose turns come first in the round, have not acted either."""
    aec = FAMILIES[name].raw_env(max_cycles=4, **ROUNDS[round])
    world, rng = aec.seated[0].view.session.world, np.random.default_rng(0)
    action, taught = world.sample_action(rng), round.startswith("students")
    partners = {TEACHER: Always(0)} if taught else {STUDENT: Always(action)}
    env = ParallelSeats(aec, partners)
    env.reset(seed=1)
    twin = copy.deepcopy(env)
    for _ in range(3):
        given = {"action": action, "ask": 0} if isinstance(aec.action_space(STUDENT), spaces.Dict) else action
        actions = dict.fromkeys(env.agents, given if taught else 3 if aec.speech == "kinds" else "Hm.")
        with pytest.raises(ValueError, match=f"(?s){env.agents[-1]}: .* nan.*; the state is unchanged"):
            env.step({**actions, env.agents[-1]: float("nan")})
        assert plain(env.step(actions)) == plain(twin.step(actions))


@pytest.mark.parametrize("seating", ["tutoring", "classroom"])
def test_teachers_and_students_do_not_act_at_once(seating):
    with pytest.raises(ValueError, match="must be teachers alone or students alone, since both act in turns"):
        ParallelSeats(GRID.raw_env(seating=seating, speech="kinds"), {})
