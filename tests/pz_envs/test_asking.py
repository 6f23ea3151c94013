"""A student who asks, in every seating and form."""

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import llf_teacher
from pz_envs.family import all_families
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.testing import require_aec
from teachers.atoms import FN, FP, ParseFailure
from teachers.common import MayAsk
from worlds.testing import plain

GRID = next(family for family in all_families() if "gridworld-v0" in family.environments)
COST = 0.25
QUESTION = 4  # of a student who has four actions


def opened(**settings):
    env = GRID.raw_env(ask_cost=COST, **settings)
    env.reset(seed=3)
    return env


def quiet(env):
    """Let the teacher say nothing."""
    env.step("" if env.speech == "message" else 0)


@pytest.mark.parametrize("speech", ["message", "kinds", "claims"])
def test_the_teacher_sees_that_it_is_asked_and_is_the_next_to_act(speech):
    env = opened(speech=speech)
    quiet(env)
    env.step(QUESTION)
    assert env.rewards == {TEACHER: 0.0, STUDENT: -COST}
    assert env.agent_selection == TEACHER
    assert env.infos[TEACHER]["asked"] is True
    if speech == "message":
        assert {atom.kind for atom in env.infos[TEACHER]["suggestion"].atoms} == {FP, FN}
    else:
        assert env.observe(TEACHER)["asked"].tolist() == [1]
        assert env.observe(TEACHER)["available"].tolist() == [0, 0, 0, 1, 1]
    quiet(env)
    assert env.agent_selection == STUDENT
    env.step(0)
    if speech != "message":
        assert env.observe(TEACHER)["asked"].tolist() == [0]


def test_a_second_question_in_a_turn_costs_the_turn():
    env = opened(speech="kinds", max_cycles=2)
    quiet(env)
    env.step(QUESTION)
    quiet(env)
    before = plain(env.session.world.save())
    env.step(QUESTION)
    assert type(env.session.moment.action) is ParseFailure
    assert (env.session.moment.turn, plain(env.session.world.save())) == (1, before)
    quiet(env)
    env.step(QUESTION)  # in the next turn it may ask again
    assert env.session.moment.turn == 1
    quiet(env)
    env.step(QUESTION)
    quiet(env)
    assert env.truncations[STUDENT]


def test_who_may_not_ask_has_no_such_action():
    env = GRID.raw_env(speech="kinds")
    env.reset(seed=3)
    quiet(env)
    with pytest.raises(ValueError, match="action 4 is not in the action space"):
        env.step(QUESTION)
    assert "asked" not in env.observe(TEACHER)
    assert not any(isinstance(atom.claim, MayAsk) for atom in env.infos[STUDENT]["atoms"])


def test_the_instruction_says_so_and_what_it_says_holds():
    env = llf_teacher.make("llf-gridworld-v0", ask_cost=COST, text=True, privileged_info=True)
    _, info = env.reset(seed=3)
    (told,) = [atom for atom in info["atoms"] if isinstance(atom.claim, MayAsk)]
    assert told.claim.holds(info["moment"], env.session.world.scratch())
    assert not MayAsk(cost=2 * COST).holds(info["moment"], env.session.world.scratch())
    assert told.text in env.session.instruction


def test_asking_through_gymnasium():
    env = llf_teacher.make("llf-gridworld-v0", ask_cost=COST, teacher="silent")
    check_env(env, skip_render_check=True)
    env = llf_teacher.make("llf-gridworld-v0", ask_cost=COST, feedback_type="fp", text=True)
    env.reset(seed=3)
    _, reward, terminated, truncated, info = env.step("ask")
    assert (reward, terminated, truncated) == (-COST, False, False)
    (advice,) = info["atoms"]
    assert env.step(str(advice.claim.action))[1] == 0.0


@pytest.mark.parametrize("id", ["llf-optimization-Booth-v0", "llf-gridworld-v0", "llf-poem-Haiku-v0"])
@pytest.mark.parametrize("student", ["random", "obedient"])
def test_students_that_never_ask_play_where_they_may(id, student):
    asked, plainly = (llf_teacher.TeacherEnv(id, student=student, **more) for more in ({"ask_cost": COST}, {}))
    for env in (asked, plainly):
        env.reset(seed=1)
    for _ in range(3):
        assert asked.step(0b01000)[1:4] == plainly.step(0b01000)[1:4]
        assert plain(asked.moment.action) == plain(plainly.moment.action)


@pytest.mark.parametrize("speech", ["kinds", "claims"])
def test_a_teacher_env_answers_a_student_who_asks(speech):
    class Curious:
        """Asks before each action, and goes where it is told to."""

        reads = "atoms"

        def reset(self, rng):
            self.asked = False

        def act(self, observation, info):
            self.asked = not self.asked
            return QUESTION if self.asked else info["atoms"][0].claim.action

    env = llf_teacher.TeacherEnv(
        "llf-gridworld-v0", student=Curious(), speech=speech, ask_cost=COST, until_success=True
    )
    observation, _ = env.reset(seed=3)
    assert env.observation_space.contains(observation)
    done, turns = False, 0
    while not done:
        advice = 0b01000 if speech == "kinds" else int(observation["claims"][:, 3].argmax()) + 1
        asked = bool(observation["asked"][0])
        observation, _, terminated, truncated, _ = env.step(advice if asked else 0)
        if asked and speech == "claims" and not (terminated or truncated):
            observation, _, terminated, truncated, _ = env.step(0)
        done = terminated or truncated
        turns += 1
    assert env.session.moment.success
    assert turns == 2 * env.session.moment.turn + 1


def test_a_class_where_one_asks():
    env = GRID.raw_env(seating="classroom", students=3, ask_cost=COST, speech="kinds")
    env.reset(seed=3)
    env.step(0)
    env.step(0)  # student_0 acts
    assert env.agent_selection == "student_1"
    env.step(QUESTION)
    assert env.agent_selection == TEACHER
    assert env.infos[TEACHER]["asking"] == 1
    observation = env.observe(TEACHER)
    assert observation["asking"].tolist() == [0, 1, 0]
    assert np.flatnonzero(observation["action_mask"]).tolist() == [0, *(env.address(1, k) for k in (8, 16, 24))]
    env.step(env.address(1, 8))
    assert env.rewards[TEACHER] == pytest.approx(-env.attention_cost - env.budget.cost)
    assert [atom.kind for atom in env.observe("student_1")["feedback"].atoms] == [FP]
    assert env.agent_selection == "student_1"
    env.step(0)
    assert env.agent_selection == "student_2"


def test_a_panel_is_asked_all_at_once():
    env = GRID.raw_env(seating="panel", ask_cost=COST, speech="kinds", feedback_type="fp")
    env.reset(seed=3)
    quiet(env)
    quiet(env)
    env.step(QUESTION)
    assert env.rewards == {"teacher_0": 0.0, "teacher_1": 0.0, STUDENT: -COST}
    env.step(8)
    env.step(8)
    assert [atom.speaker for atom in env.observe(STUDENT)["feedback"].atoms] == ["teacher_0", "teacher_1"]
    assert env.session.moment.turn == 0


@pytest.mark.parametrize("seating", ["tutoring", "classroom", "panel"])
@pytest.mark.parametrize("speech", ["kinds", "claims"])
def test_pettingzoo_accepts_it(seating, speech):
    more = {"students": 3} if seating == "classroom" else {}
    require_aec(lambda: GRID.raw_env(seating=seating, speech=speech, ask_cost=COST, max_cycles=5, **more))
