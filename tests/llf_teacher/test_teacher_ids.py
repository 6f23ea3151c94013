"""The teacher's seat by Gymnasium's ids, and its compact actions."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import llf_teacher
from llf_teacher.gym.vector import TeacherVectorEnv
from llf_teacher.registry import PREFIX, TEACHER, entries
from pz_envs.family import all_families
from teachers.feedback import SUBSETS
from worlds.testing import plain

GRID = f"{TEACHER}gridworld-v0"
FIRST = [TEACHER + family.showcase[0] for family in all_families()]
SMALL = {"pool": 4}


def test_every_environment_has_a_teachers_seat():
    for id in entries():
        spec = gymnasium.spec(TEACHER + id.removeprefix(PREFIX))
        assert spec.kwargs == {"env_id": id, "actions": "compact"}


@pytest.mark.parametrize("id", FIRST)
def test_the_seats_pass_gymnasiums_check(id):
    env = gymnasium.make(id, feedback_type="fp")
    assert env.unwrapped.subsets == (0, 0b01000)
    assert env.action_space.n == 2
    check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.parametrize("kinds", ["a", "fp", "hp+hn", "r+hn+fn", "m", "n"])
@pytest.mark.parametrize("more", [{}, {"budget": 3}, {"episodes": 2, "student": "q_learning(forget=False)"}])
def test_compact_actions_are_the_legal_ones_of_all(kinds, more):
    """The same is seen, paid and said; what is left out is never legal."""
    envs = [
        llf_teacher.TeacherEnv("llf-gridworld-v0", actions=actions, feedback_type=kinds, max_turns=5, **more)
        for actions in ("all", "compact")
    ]
    every, compact = envs
    kept = np.array(compact.subsets)
    rng = np.random.default_rng(0)
    for seed in range(4):
        (seen, _), (few, _) = (env.reset(seed=seed) for env in envs)
        done = False
        while not done:
            assert compact.observation_space.contains(few)
            assert few["action_mask"].tolist() == seen["action_mask"][kept].tolist()
            assert compact.action_masks().tolist() == every.action_masks()[kept].tolist()
            assert not np.delete(seen["action_mask"], kept).any()
            action = int(rng.integers(len(kept)))
            seen, *outcome, info = every.step(int(kept[action]))
            few, *same, same_info = compact.step(action)
            assert outcome == same
            assert info["trimmed"] == same_info["trimmed"]
            assert plain({**seen, "action_mask": 0}) == plain({**few, "action_mask": 0})
            assert every.session.feedback == compact.session.feedback
            done = any(outcome[1:])


def test_vectors_have_the_same_actions():
    settings = {"feedback_type": "fp+fn", "student": "q_learning(trust=1.0)"}
    arrays = gymnasium.make_vec(GRID, num_envs=3, **settings, **SMALL)
    assert isinstance(arrays, TeacherVectorEnv)
    sync = gymnasium.make_vec(GRID, num_envs=3, vectorization_mode="sync", **settings)
    single = gymnasium.make(GRID, **settings)
    assert arrays.single_action_space == sync.single_action_space == single.action_space == gymnasium.spaces.Discrete(4)
    assert arrays.single_observation_space == sync.single_observation_space == single.observation_space
    (one, _), (other, _) = arrays.reset(seed=3), sync.reset(seed=3)
    np.testing.assert_allclose(one["features"], other["features"], rtol=1e-6)
    assert (one["action_mask"] == other["action_mask"]).all()
    assert arrays.action_masks().shape == (3, 4)
    with pytest.raises(ValueError, match=r"action 4 of row 1 is not in Discrete\(4\)"):
        arrays.step(np.array([0, 4, 0]))


@pytest.mark.parametrize("id", FIRST)
def test_what_arrays_cannot_teach_is_taught_one_by_one(id):
    family = entries()[PREFIX + id.removeprefix(TEACHER)].family
    envs = gymnasium.make_vec(id, num_envs=2, **(SMALL if id == GRID else {}))
    assert isinstance(envs, TeacherVectorEnv if family.world_batch else gymnasium.vector.SyncVectorEnv)
    envs.reset(seed=0)
    observations, *_ = envs.step(np.array([0, 1]))
    assert observations["action_mask"].shape == (2, envs.single_action_space.n)


def test_elsewhere_there_are_all_subsets():
    assert llf_teacher.TeacherEnv("llf-gridworld-v0", feedback_type="fp").action_space.n == SUBSETS
    assert TeacherVectorEnv("llf-gridworld-v0", 2, feedback_type="fp", **SMALL).single_action_space.n == SUBSETS


@pytest.mark.parametrize(
    ("settings", "match"),
    [
        ({"actions": "few"}, "actions 'few' is unknown; allowed: all, compact"),
        ({"actions": "compact", "speech": "message"}, "actions='compact' needs speech='kinds', got 'message'"),
    ],
)
def test_bad_arguments(settings, match):
    with pytest.raises(ValueError, match=match):
        llf_teacher.TeacherEnv("llf-gridworld-v0", **settings)


@pytest.mark.parametrize("action", [2, -1, 0.5, "0", None])
def test_what_is_no_action_is_refused(action):
    env = gymnasium.make(GRID, feedback_type="fp")
    env.reset(seed=0)
    with pytest.raises(ValueError, match="the action must be an integer from 0 to 1, got"):
        env.step(action)
