"""The classroom: turns, attention, costs, leaving, seeds, and its parallel form."""

import copy
import pickle

import gymnasium
import numpy as np
import pettingzoo
import pytest
from design import sampled
from playing import agents

import llf_teacher
from pz_envs.family import all_families
from pz_envs.scripted import RULES
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.testing import require_aec, require_parallel
from teachers.atoms import Utterance
from teachers.seeds import Seeds
from worlds.testing import plain

GRID, BANDIT = (next(f for f in all_families() if f.name == name) for name in ("gridworld", "bandits"))
ALL = 31


def ids():
    return ["{}-classroom-{}".format(*f.showcase[0].rsplit("-", 1)) for f in all_families()]


def optimal(env, agent):
    session = env.sessions[int(agent.rpartition("_")[2])]
    plan = session.teacher.oracle.plan(session.moment.after, 1)
    return plan[0] if plan else session.world.sample_action(np.random.default_rng(0))


def act(env, agent, observation):
    if agent == TEACHER:
        return int(np.flatnonzero(observation["action_mask"])[-1])
    return optimal(env, agent)


def play(env, seed=0):
    """Every turn as `agents` gives it."""
    return agents(env, lambda agent, observation: act(env, agent, observation), seed)


@sampled(lambda id, speech, text: {(id, speech), (speech, text)})
@pytest.mark.parametrize("id", ids())
@pytest.mark.parametrize("speech", ["kinds", "message"])
@pytest.mark.parametrize("text", [False, True])
def test_pettingzoo_accepts_it(id, speech, text):
    settings = {"students": 3, "attention": 2, "max_cycles": 5, "text": text}
    require_aec(lambda: pettingzoo.make("aec", f"llf/{id}", speech=speech, **settings))
    if speech == "kinds":
        require_parallel(lambda: pettingzoo.make("parallel", f"llf/{id}", **settings))


@pytest.mark.parametrize("students", [1, 2, 16, pytest.param(64, marks=pytest.mark.full)])
def test_pettingzoo_accepts_every_size(students):
    require_aec(lambda: GRID.env(seating="classroom", students=students, attention=students))


def test_a_round_is_the_teachers_turns_and_then_the_students():
    env = GRID.raw_env(seating="classroom", students=3, attention=2, until_success=False, max_cycles=2)
    alive = [agent for agent, dead, *_ in play(env) if not dead]
    students = [f"student_{i}" for i in range(3)]
    assert alive == [TEACHER, TEACHER, *students] * 2 + [TEACHER, TEACHER]


def test_nobody_ends_the_teachers_part():
    env = GRID.raw_env(seating="classroom", students=3, attention=3)
    env.reset(seed=0)
    env.step(0)
    assert env.agent_selection == "student_0"
    assert all(env.observe(student)["feedback"] == "" for student in env.students)


def test_only_who_is_spoken_to_hears_anything():
    env = BANDIT.raw_env(seating="classroom", students=4, attention=2)
    env.reset(seed=0)
    assert all(env.observe(student)["instruction"] for student in env.students)
    env.step(env.address(3, ALL))
    env.step(env.address(1, 0b01000))
    heard = [bool(env.observe(student)["feedback"]) for student in env.students]
    assert heard == [False, True, False, True]
    assert [atom.kind for atom in env.observe("student_1")["feedback"].atoms] == ["fp"]


def test_attention_on_one_who_heard_already_is_wasted():
    env = BANDIT.raw_env(seating="classroom", students=3, attention=2, cost=0.0, attention_cost=0.5)
    env.reset(seed=0)
    env.step(env.address(2, 0b01000))
    before = env.observe("student_2")["feedback"]
    env.step(env.address(2, ALL))
    assert env.observe("student_2")["feedback"] == before
    assert env.rewards[TEACHER] == -0.5
    assert env.agent_selection == "student_0"


def test_the_mask_is_exact():
    env = GRID.raw_env(seating="classroom", students=3, attention=3)
    env.reset(seed=0)
    for round_ in range(4):
        observation = env.observe(TEACHER)
        for i in range(3):
            kinds = sum(int(bit) << k for k, bit in enumerate(observation["available"][i]))
            mine = observation["action_mask"][[env.address(i, subset) for subset in range(1, 32)]]
            assert mine.tolist() == [int(not subset & ~kinds) for subset in range(1, 32)]
        env.step(env.address(1, kinds := 0b01000))
        after = env.observe(TEACHER)
        assert not after["action_mask"][[env.address(1, subset) for subset in range(1, 32)]].any()
        assert after["students"][:, 5].tolist() == [0, 1, 0]
        assert after["remaining"].tolist() == pytest.approx([2 / 3, 1])
        env.step(0)
        assert env.observe(TEACHER)["action_mask"].sum() == 1, "when a student acts, the teacher can say nothing"
        for _student in env.students:
            env.step(round_ % 4)


def test_observations_are_in_their_spaces_and_what_they_are_said_to_be():
    env = GRID.raw_env(seating="classroom", students=4, attention=2, budget=20)
    for agent, dead, observation, _, info in play(env, seed=3):
        assert observation in env.observation_space(agent)
        if agent == TEACHER and not dead:
            for i, moment in enumerate(info["moments"]):
                turn, reward, importance, over, present, _ = observation["students"][i].tolist()
                assert present == (f"student_{i}" in env.agents)
                assert (turn, reward, over) == (pytest.approx(moment.turn / 20), moment.reward, moment.over)
                assert importance == (0 if moment.over else env.sessions[i].teacher.oracle.importance(moment.after))
    assert env.budget.spent == 20


def test_students_leave_when_they_are_done_and_hear_a_last_word():
    env = GRID.raw_env(seating="classroom", students=6, attention=6)
    left, last = [], {}
    for agent, dead, observation, _, info in play(env, seed=1):
        if dead:
            left.append(agent)
            last[agent] = observation
            assert env.terminations[agent]
            assert agent == TEACHER or info["success"]
    turns = [session.moment.turn for session in env.sessions]
    assert len(set(turns)) > 1, "they finish at different times"
    assert [turns[int(agent[-1])] for agent in left if agent != TEACHER] == sorted(turns)
    assert all(last[agent]["feedback"] for agent in env.students)
    assert env.agents == []


def test_the_teacher_is_truncated_with_anyone():
    env = GRID.raw_env(seating="classroom", students=2, max_cycles=1)
    assert all(env.truncations[agent] for agent, dead, *_ in play(env) if dead)


def test_rewards_and_costs():
    env = BANDIT.raw_env(seating="classroom", students=2, attention=1, cost=0.25, attention_cost=0.5, max_cycles=1)
    turns = [(agent, dead, reward) for agent, dead, _, reward, _ in play(env)]
    # Attention, and the one kind of advice that the greatest legal action of the last student says.
    paid = [reward for agent, dead, reward in turns if agent == TEACHER and not dead]
    students = [reward for agent, dead, reward in turns if agent != TEACHER and dead]
    atoms = len(env.sessions[1].feedback.atoms)
    assert paid == [0.0, pytest.approx(-0.5 - 0.25 * 2 + sum(students))]
    assert atoms == 2
    assert [reward for agent, dead, reward in turns if agent == TEACHER and dead] == [-0.5 - 0.25 * atoms]


def test_the_teachers_reward_can_be_named_or_a_function():
    for reward, expected in (("student_progress", 0.0), (lambda moment, oracle: 7.0, 7.0)):
        env = GRID.raw_env(seating="classroom", students=2, teacher_reward=reward)
        env.reset(seed=0)
        env.step(0)
        env.step(optimal(env, "student_0"))
        assert env.rewards == {TEACHER: expected, "student_0": 0.0, "student_1": 0.0}


def test_each_student_is_taught_as_in_a_tutoring_env():
    """A student's world, words and rewards are those of seats of its own with the same seed: the first one's is that of
    the class.
    """
    env = GRID.raw_env(seating="classroom", students=3, attention=3, until_success=False, max_cycles=5)
    env.reset(seed=5)
    seeds = [5, *Seeds(5).stream("class").integers(2**31, size=3)[1:].tolist()]
    alone = []
    for seed in seeds:
        seat = GRID.raw_env(speech="kinds", max_cycles=5)
        seat.reset(seed=seed)
        alone.append(seat)
    while env.agents:
        agent = env.agent_selection
        _observation, _, terminated, truncated, _ = env.last()
        if terminated or truncated:
            env.step(None)
        elif agent == TEACHER:
            for i, seat in enumerate(alone):
                env.step(env.address(i, ALL))
                seat.step(ALL)
                assert plain(env.observe(f"student_{i}")) == plain(seat.observe(STUDENT))
        else:
            seat = alone[int(agent[-1])]
            action = seat.session.moment.turn % 4
            env.step(action)
            seat.step(action)
            assert env.rewards[agent] == seat.rewards[STUDENT]


def test_same_world():
    env = GRID.raw_env(seating="classroom", students=3, same_world=True)
    env.reset(seed=0)
    assert len({session.world.truth for session in env.sessions}) == 1
    assert len({session.world for session in env.sessions}) == 3
    env = GRID.raw_env(seating="classroom", students=3)
    env.reset(seed=0)
    first = [session.world.truth for session in env.sessions]
    assert len(set(first)) == 3
    env.reset()
    second = [session.world.truth for session in env.sessions]
    assert not set(first) & set(second)
    env.reset(seed=0)
    assert [session.world.truth for session in env.sessions] == first
    env.reset()
    assert [session.world.truth for session in env.sessions] == second


def test_messages():
    env = GRID.raw_env(seating="classroom", students=2, attention=2, speech="message", budget=2)
    env.reset(seed=0)
    assert env.observe(TEACHER)["student_1"]["state"].startswith("Room: ")
    env.step({"student": 2, "words": "Mind the stairs."})
    assert env.observe("student_1")["feedback"] == "Mind the stairs."
    teacher = GRID.make_teacher(env.sessions[0].world)
    teacher.reset(np.random.default_rng(0))
    said = teacher.speak(env.sessions[0].moment)
    env.step({"student": 1, "words": said})
    heard = env.observe("student_0")["feedback"]
    assert type(heard) is Utterance
    assert [atom.kind for atom in heard.atoms] == ["fp"], "no instruction again, and one atom is left in the budget"


def test_text_that_is_no_action_is_answered_without_attention():
    env = GRID.raw_env(seating="classroom", students=2, text=True)
    env.reset(seed=0)
    env.step(0)
    env.step("hmm")
    env.step("north")
    env.step(0)
    assert env.observe("student_0")["feedback"]
    assert not env.observe("student_1")["feedback"]
    assert env.budget.spent == 0


def test_only_the_teacher_sees_the_moments():
    env = GRID.raw_env(seating="classroom", students=2)
    env.reset(seed=0)
    env.step(0)
    env.step(0)
    assert "moments" in env.infos[TEACHER]
    assert "moment" not in env.infos["student_0"]
    assert set(env.observe("student_0")) == {"state", "instruction", "feedback"}


@pytest.mark.parametrize("rule", RULES)
def test_rules_of_attention(rule):
    env = GRID.parallel_env(seating="classroom", students=4, attention=1, rule=rule, until_success=False, max_cycles=8)
    observations, _ = env.reset(seed=0)
    heard = []
    while env.agents:
        heard.append([agent for agent in env.agents if observations[agent]["feedback"]])
        observations, rewards, terminations, truncations, infos = env.step(dict.fromkeys(env.agents, 0))
        assert observations.keys() == rewards.keys() == terminations.keys() == truncations.keys() == infos.keys()
    assert all(len(each) <= 1 for each in heard)
    if rule == "round_robin":
        assert [each[0] for each in heard[:4]] == [f"student_{i}" for i in range(4)]


@pytest.mark.parametrize("seating", ["classroom", "panel"])
def test_the_parallel_form_has_kinds_only(seating):
    assert GRID.parallel_env(seating=seating, speech="kinds").env.speech == "kinds"
    for speech, match in (("message", "speech 'message' has no parallel form.*; allowed: kinds"), ("song", "unknown")):
        with pytest.raises(ValueError, match=match):
            pettingzoo.make("parallel", f"llf/gridworld-{seating}-v0", speech=speech)


def test_rendering():
    env = GRID.raw_env(seating="classroom", students=2, render_mode="ansi")
    env.reset(seed=0)
    assert env.render().count("Teacher: ") == 2
    assert env.render().count("Room: ") == 2


def test_a_lesson_has_classrooms_and_panels():
    lesson = llf_teacher.Lesson(lambda: gymnasium.make("FrozenLake-v1", is_slippery=False))
    require_aec(lambda: lesson.env(seating="classroom", students=3, attention=2))
    require_aec(lambda: lesson.env(seating="panel", teachers=("oracle", "silent")))


def test_classrooms_copy_and_pickle():
    env = GRID.raw_env(seating="classroom", students=3, attention=2)
    env.reset(seed=0)
    env.step(env.address(1, ALL))
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert plain(other.observe(TEACHER)) == plain(env.observe(TEACHER))
        other.step(0)
        assert env.agent_selection == TEACHER
