"""The state of all seats in numbers, teachers that observe one array, and PettingZoo's checkers over every seating."""

import warnings

import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test
from pettingzoo.test.state_test import test_state as check_state
from pettingzoo.test.state_test import test_state_space as check_state_space
from shelf import FAMILIES

import llf_teacher  # noqa: F401 (registers the environments)
from pz_envs.seats import STUDENT, TEACHER
from pz_envs.subject import seating_names
from pz_envs.testing import expected_warnings
from worlds.testing import plain

_BOXES = "The class of observation spaces is different|Observations are different shapes"  # of two seats
NUMBERS = {"speech": "kinds", "numbers": True, "teacher_numbers": True}
GRID = {seating: f"llf/gridworld{'' if seating == 'tutoring' else f'-{seating}'}-v0" for seating in seating_names()}


def fields_of(env, state):
    return {field.name: state[field.place] for field in env.state_fields}


@pytest.mark.parametrize("more", [{}, {"episodes": 2, "max_cycles": 4}, {"teacher_numbers": True, "speech": "kinds"}])
@pytest.mark.parametrize("seating", seating_names())
def test_every_seating_passes_pettingzoos_checkers(seating, more):
    if seating == "curriculum" and "episodes" in more:
        more = {"lessons": 2, "max_cycles": 4}
    settings = {**more, **(NUMBERS if "teacher_numbers" in more and seating != "panel" else {})}

    def make():
        return pettingzoo.make("aec", GRID[seating], **settings)

    with expected_warnings():
        warnings.filterwarnings("ignore", message=_BOXES)
        check_state_space(make())
        check_state(make(), 20)
        api_test(make(), num_cycles=20)
        seed_test(make, num_cycles=20)
        if "teacher_numbers" not in more or seating == "tutoring":
            parallel = pettingzoo.make("parallel", GRID[seating], **settings)
            check_parallel = parallel_api_test(parallel, num_cycles=20)
            assert check_parallel is None
            parallel_seed_test(lambda: pettingzoo.make("parallel", GRID[seating], **settings), num_cycles=20)
            parallel.reset(seed=1)
            assert parallel.state_space.contains(parallel.state())


@pytest.mark.parametrize("family", FAMILIES.values(), ids=lambda family: family.name)
def test_fields_fill_the_state_and_texts_are_left_out(family):
    env = family.raw_env(speech="kinds", **family.environments[family.showcase[0]])
    env.reset(seed=3)
    places = [field.place for field in env.state_fields]
    assert [place.start for place in places] == [0, *(place.stop for place in places[:-1])]
    assert places[-1].stop == env.state_space.shape[0]
    assert all(field.meaning for field in env.state_fields)
    assert len({field.name for field in env.state_fields}) == len(places)
    assert env.state_space.contains(env.state())
    embedded = family.raw_env(
        speech="kinds",
        numbers=True,
        embed=lambda text: [len(text) % 7],
        **family.environments[family.showcase[0]],
    )
    embedded.reset(seed=3)
    assert embedded.state_space.contains(embedded.state())
    assert embedded.state_space.shape[0] > env.state_space.shape[0]


def test_the_state_says_who_acts_what_is_worth_what_and_what_can_be_said():
    env = pettingzoo.make("aec", GRID["tutoring"], speech="kinds", budget=4)
    env.reset(seed=7)
    session = env.unwrapped.session
    now = fields_of(env, env.state())
    assert now["acts"].tolist() == [1, 0]
    assert now["student_0.values"].tolist() == list(session.teacher.oracle.values(session.moment.after))
    assert now["student_0.teacher_0.available"].tolist() == env.observe(TEACHER)["available"].tolist()
    assert now["student_0.state.room"].argmax() == session.state["room"]
    env.step(0b01000)
    now = fields_of(env, env.state())
    assert now["acts"].tolist() == [0, 1]
    assert now["student_0.fp.said"].tolist() == [1]
    assert now["student_0.teacher_0.budget"].tolist() == [0.75]
    assert now["student_0.fp.action"].argmax() == session.teacher.oracle.plan(session.moment.after, 1)[0]


def test_a_class_shares_attention_and_a_lifetime_counts_episodes():
    env = pettingzoo.make(
        "aec", GRID["classroom"], students=2, attention=2, attention_cost=0.0, episodes=2, max_cycles=1
    )
    env.reset(seed=7)
    seen = []
    for agent in env.agent_iter():
        _, _, terminated, truncated, _ = env.last()
        found = fields_of(env, env.state())
        seen.append((float(found["attention"][0]), float(found["episode"][0]), bool(found["student_1.here"][0])))
        env.step(None if terminated or truncated else env.unwrapped.address(0, 8) if agent == TEACHER else 0)
    assert {attention for attention, _, _ in seen} >= {0.5, 1.0}
    assert {episode for _, episode, _ in seen} == {0.0, 0.5}


def test_a_teachers_array_is_its_dict_and_its_info_has_the_mask():
    made = [
        pettingzoo.make("aec", GRID["tutoring"], speech="kinds", **more) for more in ({}, {"teacher_numbers": True})
    ]
    for env in made:
        env.reset(seed=5)
    wordy, flat = made
    fields = {field.name: field for field in flat.fields_of(TEACHER)}
    assert list(fields) == ["available", "features"]
    assert flat.fields_of(STUDENT) == ()
    rng = np.random.default_rng(0)
    for _ in range(9):
        seen, array = (env.observe(TEACHER) for env in made)
        for name, field in fields.items():
            assert np.array_equal(array[field.place], np.asarray(seen[name], np.float32))
        info = flat.unwrapped.infos[TEACHER]
        assert sorted(info) == ["action_mask", "trimmed"]
        assert np.array_equal(info["action_mask"], seen["action_mask"])
        action = int(rng.integers(32 if wordy.agent_selection == TEACHER else 4))
        for env in made:
            env.step(action)


@pytest.mark.parametrize(
    ("form", "id", "settings", "match"),
    [
        ("aec", "tutoring", {"teacher_numbers": True}, "set speech to 'kinds' or 'claims'"),
        ("parallel", "classroom", {"teacher_numbers": True}, "not used in this parallel form"),
        ("parallel", "panel", {"teacher_numbers": True}, "not used in this parallel form"),
        ("aec", "tutoring", {"teacher_numbers": 1}, "teacher_numbers must be True or False, got 1"),
    ],
)
def test_what_cannot_be_one_array_is_refused(form, id, settings, match):
    with pytest.raises(ValueError, match=match):
        pettingzoo.make(form, GRID[id], **settings)


def test_environments_have_names_of_their_own():
    name = "bandits-BanditTenArmedRandomFixed"
    for id, form, found in (
        (f"llf/{name}-v0", "aec", f"{name}_v0"),
        (f"llf/{name}-v0", "parallel", f"{name}-turns_v0"),
        (f"llf/{name}-panel-v0", "aec", f"{name}-panel_v0"),
        (f"llf/{name}-classroom-v0", "parallel", f"{name}-classroom_v0"),
    ):
        env = pettingzoo.make(form, id)
        assert env.metadata["name"] == found
        assert env.metadata.get("turn_based", False) is ("turns" in found)


def test_in_the_turn_based_form_the_agent_whose_turn_it_is_must_act():
    env, twin = (pettingzoo.make("parallel", "llf/gridworld-v0", speech="kinds") for _ in range(2))
    env.reset(seed=1)
    twin.reset(seed=1)
    for actions, got in (({}, "none"), ({"student_0": 0}, "student_0")):
        with pytest.raises(ValueError, match=f"the actions lack teacher_0, whose turn it is, got those of {got}"):
            env.step(actions)
    assert plain(env.step({"teacher_0": 31})) == plain(twin.step({"teacher_0": 31, "student_0": 0}))


def test_in_the_turn_based_form_one_agent_acts_in_a_step():
    env = pettingzoo.make("parallel", GRID["tutoring"], speech="kinds")
    env.reset(seed=1)
    *_, infos = env.step({TEACHER: 0, STUDENT: 3})
    assert infos[TEACHER]["active_agent"] == STUDENT
    assert env.env.session.moment.turn == 0


def test_a_parallel_step_needs_every_agents_action():
    env = pettingzoo.make("parallel", GRID["classroom"], students=3, attention=1)
    env.reset(seed=1)
    with pytest.raises(ValueError, match="the actions lack student_1; each agent that is left must act: student_0, "):
        env.step({"student_0": 0, "student_2": 0})
    assert env.env.sessions[0].moment.turn == 0
