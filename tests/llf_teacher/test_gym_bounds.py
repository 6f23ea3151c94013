"""What Gymnasium and PettingZoo promise of options, time limits, spaces and infos."""

import gymnasium
import numpy as np
import pettingzoo
import pytest
from gymnasium.wrappers import TimeAwareObservation

import llf_teacher
from llf_teacher.registry import PREFIX
from pz_envs.family import all_families
from teachers.atoms import Utterance, atoms_of
from teachers.personality import personality
from teachers.teacher_turn import LONGEST

GRID = "llf-gridworld-v0"


def doors():
    yield "aec", pettingzoo.make("aec", "llf/gridworld-v0")
    yield "parallel", pettingzoo.make("parallel", "llf/gridworld-v0")
    yield "gymnasium", llf_teacher.make(GRID)
    yield "teacher", gymnasium.make("teacher/gridworld-v0")


@pytest.mark.parametrize("options", [{"num_rooms": 6, "nonsense": 2}, {"num_rooms": 6}, {"options": 2}, 7])
def test_every_door_refuses_options_that_its_reset_does_not_use(options):
    for name, env in doors():
        env.reset(seed=1, options={})
        with pytest.raises(ValueError, match="option"):
            env.reset(seed=0, options=options)
        if name in ("aec", "parallel"):
            env.reset(seed=0, options={"options": 1})  # as PettingZoo's checkers do


def played(env):
    """The turns of an episode, and the last observation."""
    env.reset(seed=3)
    for turn in range(1, 100):
        seen, _, terminated, truncated, _ = env.step(0)
        if terminated or truncated:
            return turn, truncated, seen
    raise AssertionError("no end")


@pytest.mark.parametrize(("settings", "turns"), [({}, 5), ({"max_turns": 9}, 5), ({"max_turns": 4}, 4)])
def test_a_time_limit_shortens_the_lesson_itself(settings, turns):
    """So that the teacher has the last word."""
    env = gymnasium.make(GRID, max_episode_steps=5, **settings)
    assert env.unwrapped.spec.max_episode_steps == env.unwrapped.session.max_turns == turns
    took, truncated, seen = played(env)
    assert (took, truncated) == (turns, True)
    assert seen["feedback"]
    assert gymnasium.make(GRID, max_episode_steps=50).unwrapped.session.max_turns == 50
    assert gymnasium.make(GRID, max_episode_steps=-1).unwrapped.session.max_turns == 20
    assert gymnasium.make_vec(GRID, num_envs=2, max_episode_steps=5).max_turns == 5
    vector = gymnasium.make_vec(GRID, num_envs=2, vectorization_mode="sync", max_episode_steps=5)
    assert [each.unwrapped.session.max_turns for each in vector.envs] == [5, 5]


@pytest.mark.parametrize("name", [GRID, "teacher/gridworld-v0"])
def test_true_is_no_number_of_steps(name):
    """Python counts it as 1, so that Gymnasium's limit cut the lesson after a step whose prompt spoke of 20."""
    with pytest.raises(ValueError, match="max_episode_steps must be an integer of at least 1, got True"):
        gymnasium.make(name, max_episode_steps=True)
    with pytest.raises(ValueError, match="got True"):
        gymnasium.make_vec(name, num_envs=2, vectorization_mode="sync", max_episode_steps=True)


def test_a_number_of_numpy_counts_as_pythons_own():
    """An `int8` overflowed in the spec, and `truncated` was no `bool`."""
    env = gymnasium.make("teacher/gridworld-v0", max_turns=np.int8(127), budget=np.int8(3))
    assert env.spec.max_episode_steps == 128
    assert {type(getattr(env.unwrapped.settings, name)) for name in ("max_turns", "budget")} == {int}
    lesson = gymnasium.make(GRID, max_turns=np.uint64(9))
    lesson.reset(seed=0)
    assert type(lesson.step(0)[3]) is bool


@pytest.mark.parametrize("episodes", [1, 3])
def test_the_teachers_seat_has_a_step_more_in_each_episode(episodes):
    env = gymnasium.make("teacher/gridworld-v0", max_episode_steps=6 * episodes, episodes=episodes, until_success=False)
    assert env.unwrapped.session.max_turns == 5
    env.reset(seed=0)
    for step in range(1, 6 * episodes + 1):
        *_, terminated, truncated, _ = env.step(0)
        assert (terminated or truncated) == (step == 6 * episodes)
    assert gymnasium.make("teacher/gridworld-v0", episodes=episodes).spec.max_episode_steps == 21 * episodes
    with pytest.raises(ValueError, match=f"max_episode_steps must be at least {2 * episodes} at this seat, got 1"):
        gymnasium.make("teacher/gridworld-v0", episodes=episodes, max_episode_steps=1)


def test_the_spec_says_how_long_an_episode_is():
    env = gymnasium.make(GRID)
    assert type(env) is llf_teacher.StudentEnv
    assert env.spec.max_episode_steps == 20
    assert TimeAwareObservation(env, flatten=False, normalize_time=False).observation_space["time"].high == 20
    assert played(gymnasium.make(env.spec))[0] == 20
    assert llf_teacher.StudentEnv(GRID).spec is None


@pytest.mark.parametrize(
    "teacher",
    [
        "end_of_episode(top_k=5000)",
        "delayed(turns=2) | end_of_episode(top_k=5000)",
        "verbose | end_of_episode(top_k=9999)",
    ],
)
def test_feedback_fits_into_its_space(teacher):
    env = llf_teacher.make(GRID, teacher=teacher, max_turns=2_000, until_success=False, text=True)
    env.reset(seed=0)
    rng, over = np.random.default_rng(0), False
    while not over:
        seen, _, terminated, truncated, info = env.step(str(rng.integers(4)))
        over = terminated or truncated
    assert LONGEST - 500 < len(seen["feedback"]) <= LONGEST
    assert env.observation_space.contains(seen)
    assert info["atoms"]
    assert " ".join(atom.text for atom in info["atoms"]) == seen["feedback"]


@personality()
def endless(claims, view):
    """Says everything a hundred times."""
    return [each for each in claims if each.kind] * 400


def test_a_personality_of_ones_own_fits_too():
    env = llf_teacher.make(GRID, teacher=endless())
    seen, _ = env.reset(seed=0)
    seen, *_ = env.step(0)
    assert LONGEST - 500 < len(seen["feedback"]) <= LONGEST


def test_the_first_claims_that_fit_are_kept():
    env = llf_teacher.make(GRID)
    env.reset(seed=0)
    said = Utterance.of(env.step(0)[-1]["atoms"])
    assert said.within(len(said)) == said
    assert said.within(len(said) - 1) == Utterance.of(said.atoms[:-1])
    assert atoms_of(said.within(0)) == ()


TYPED = {"atoms", "moment", "suggestion", "vocabulary"}


def plain(value):
    """Whether it is what JSON takes, or an array of numbers."""
    if isinstance(value, dict):
        return all(type(key) is str and plain(each) for key, each in value.items())
    if isinstance(value, list | tuple):
        return all(map(plain, value))
    return type(value) in (str, int, float, bool, type(None)) or (
        isinstance(value, np.ndarray) and value.dtype != object
    )


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_infos_hold_what_json_takes_or_arrays(family):
    """Beside the named entries with objects of ours; docs/environments.md has the rule."""
    found = []
    for settings in ({}, {"text": True}, {"text": True, "ask_cost": 0.1}, {"privileged_info": True}):
        env = llf_teacher.make(PREFIX + family.showcase[0], **settings)
        found.append(env.reset(seed=0)[1])
        found.append(
            env.step("no action" if "text" in settings else env.session.world.sample_action(np.random.default_rng(0)))[
                -1
            ]
        )
    seats = family.env()
    seats.reset(seed=0)
    found += [seats.infos[agent] for agent in seats.agents]
    for info in found:
        assert all(plain(value) for name, value in info.items() if name not in TYPED), info
