"""A curriculum's agent chooses tasks; teacher and student play lessons in them, and tests pay the choice."""

import numpy as np
import pettingzoo
import pytest

import llf_teacher  # noqa: F401 (registers the environments)
from pz_envs.seatings.curriculum import CURRICULUM
from pz_envs.seats import STUDENT, TEACHER

ID = "llf/gridworld-curriculum-v0"


def played(choices, seed=1, **settings):
    """The agents that acted, with the curriculum's rewards and infos, and the rooms in which lessons began."""
    env = pettingzoo.make("aec", ID, lessons=len(choices), **settings)
    env.reset(seed=seed)
    left, turns, starts = iter(choices), [], []
    for agent in env.agent_iter():
        observation, reward, terminated, truncated, info = env.last()
        dead = terminated or truncated
        turns.append((agent, reward, info, observation))
        if agent == TEACHER and not dead and env.seats.session.moment.turn == 0:
            starts.append((env.task, env.seats.session.state["room"]))
        if dead:
            env.step(None)
        elif agent == CURRICULUM:
            env.step(next(left))
        elif agent == TEACHER:
            env.step(0b01000)
        else:  # as advised
            env.step(int(env.seats.session.teacher.oracle.plan(env.seats.session.moment.after, 1)[0]))
    return env, turns, starts


def test_all_rooms_are_closed(monkeypatch):
    env = pettingzoo.make("aec", ID, tasks=[{"town": 1}, {"town": 2}, {"town": 1, "ahead": 0.5}])
    closed = []
    worlds = [room.session.world for room in dict.fromkeys(env.unwrapped.rooms)]
    for world in worlds:
        monkeypatch.setattr(world, "close", lambda world=world: closed.append(world))
    env.close()
    assert closed == worlds
    assert len(worlds) == 2


def test_lessons_are_in_the_chosen_tasks_and_tests_in_the_last():
    env, turns, starts = played([0, 2, 0, 1], tests=2)
    assert [task for task, _ in starts] == [0, 2, 0, 1, 3, 3]
    by_task = {task: {room for other, room in starts if other == task} for task, _ in starts}
    assert all(len(rooms) == 1 for rooms in by_task.values())
    distance = env.rooms[0].session.teacher.oracle.plan
    left = [len(distance(truth, 20)) for truth in env.starts]
    assert left == sorted(left)
    assert left[0] < left[-1] == len(distance(env.starts[-1], 20))
    assert [agent for agent, *_ in turns][:3] == [CURRICULUM, TEACHER, STUDENT]


def test_tests_pay_the_curriculum():
    _, turns, _ = played([0, 1], tests=3)
    assert sum(reward for agent, reward, *_ in turns if agent == CURRICULUM) == 3
    _, turns, _ = played([0, 1], tests=0)
    assert sum(reward for agent, reward, *_ in turns if agent == CURRICULUM) == 0


def test_the_curriculum_sees_what_came_of_its_choices():
    env, turns, _ = played([1, 1, 0], tests=1)
    seen = [(observation, info) for agent, _, info, observation in turns if agent == CURRICULUM]
    assert [info["task"] for _, info in seen] == [-1, 1, 1, 3]
    fields = {field.name: field.place for field in env.fields_of(CURRICULUM)}
    last = seen[2][0]
    assert last[fields["left"]] == pytest.approx(1 / 3)
    assert last[fields["task_1.0"]] == pytest.approx(2 / 3)
    assert last[fields["task_1.1"]] == 1
    assert last[fields["task_0.0"]] == 0


def test_students_learn_how_their_lessons_ended():
    _, turns, _ = played([0, 1], tests=1)
    first = [info for agent, _, info, _ in turns if agent == STUDENT and "final_obs" in info]
    assert [info["final_terminated"] for info in first] == [True, True]


def test_tasks_are_worlds_too():
    env, *_ = played([0, 1], tasks=[{"town": 3}, {"town": 4}, {"town": 3, "ahead": 0.5}], tests=1)
    assert env.rooms[0] is not env.rooms[1]
    laws = [room.session.world.law for room in env.rooms]
    assert laws[0] == laws[2]
    assert env.state_space.contains(env.state())


def test_one_budget_is_for_all_lessons():
    _, turns, _ = played([0, 1, 2], tests=1, budget=2, cost=1.0)
    assert sum(reward for agent, reward, *_ in turns if agent == TEACHER) == pytest.approx(-2 + 4)


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"tasks": []}, r"tasks must be a list of at least one mapping, such as \[\{'ahead': 0.5\}, \{\}\], got \[\]"),
        ({"tasks": [{}, {"rooms": 3}]}, "task 1 has an unknown option 'rooms'; allowed: ahead, num_rooms"),
        ({"tasks": [{"ahead": 1}]}, "ahead of task 0 must be a number from 0 to less than 1, got 1"),
        ({"tasks": [{}, {"num_rooms": 8}]}, "task 1 has another observation space of student_0 than task 0"),
        ({"lessons": 0}, "lessons must be an integer of at least 1 and tests of at least 0, got 0 and 1"),
        ({"episodes": 3}, "a curriculum does not use episodes=3; give lessons= and tests="),
    ],
)
def test_what_is_no_curriculum_is_refused(settings, match):
    with pytest.raises(ValueError, match=match):
        pettingzoo.make("aec", ID, **settings)


def test_a_start_on_the_way_needs_a_way():
    with pytest.raises(ValueError, match="ahead of task 0 must be 0: bandits has no plan that leads to success"):
        pettingzoo.make("aec", "llf/bandits-BanditTenArmedRandomFixed-curriculum-v0", tasks=[{"ahead": 0.5}])


@pytest.mark.parametrize("choice", [4, -1, 0.5, np.array([0])])
def test_a_choice_that_is_no_task_is_refused(choice):
    env = pettingzoo.make("aec", ID)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the curriculum must choose a task from 0 to 3, got"):
        env.step(choice)
