"""The teacher's seat as a Gymnasium environment, and teachers of one's own."""

import pytest
from gymnasium.utils.env_checker import check_env
from playing import earned, episode

import llf_teacher
from llf_teacher.registry import PREFIX
from pz_envs.family import all_families
from teachers.personalities.mistake import mistake

GRID = "llf-gridworld-v0"
SHOWCASE = [PREFIX + family.showcase[0] for family in all_families()]


@pytest.mark.parametrize("id", SHOWCASE)
@pytest.mark.parametrize("speech", ["kinds", "message"])
def test_teacher_env_passes_gymnasiums_check(id, speech):
    check_env(llf_teacher.TeacherEnv(id, speech=speech), skip_render_check=True)


@pytest.mark.parametrize("student", ["random", "obedient", "text_only", "reward_only", "oracle"])
@pytest.mark.parametrize("id", SHOWCASE)
def test_teacher_env_with_every_student(id, student):
    def taught():
        env = llf_teacher.TeacherEnv(id, student=student, cost=0.0)
        return [(reward, info["moment"].success) for _, reward, _, _, info in episode(env, 31, seed=1)]

    assert taught() == taught()
    if student in ("obedient", "oracle"):
        assert taught()[-1][1]


def test_teaching_pays():
    """An obedient student that is told everything earns its teacher more than one that is told nothing."""
    env = llf_teacher.TeacherEnv(GRID, cost=0.01)
    assert earned(env, 8) > earned(env, 0)
    assert env.action_space.n == 32


def test_action_masks_for_maskable_learners():
    env = llf_teacher.TeacherEnv(GRID)
    observation, _ = env.reset(seed=0)
    assert env.action_masks().dtype == bool
    assert env.action_masks().tolist() == observation["action_mask"].astype(bool).tolist()
    assert env.action_masks()[0]


def test_there_are_no_action_masks_for_messages():
    env = llf_teacher.TeacherEnv(GRID, speech="message")
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"needs speech='kinds'; with speech='message' any text can be said"):
        env.action_masks()


def test_a_teacher_of_ones_own_takes_the_seat():
    class Parrot:
        def reset(self, rng):
            self.turns = 0

        def act(self, observation, info):
            self.turns += 1
            return f"Turn {self.turns}: I see {observation['action'] or 'nothing'}."

    env = llf_teacher.make(GRID, teacher=Parrot())
    observation, info = env.reset(seed=0)
    assert observation["instruction"] == "Turn 1: I see nothing."
    observation, *_, info = env.step(2)
    assert observation["feedback"] == "Turn 2: I see west."
    assert info["atoms"] == ()


def test_personalities_in_python():
    env = llf_teacher.make(GRID, teacher=mistake(eps=1.0))
    env.reset(seed=0)
    assert str(env.teacher.personality) == "mistake(eps=1.0)"
