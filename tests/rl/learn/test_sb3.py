"""stable-baselines3 and sb3-contrib: the student's seat in numbers, the teacher's with compact actions."""

import gymnasium
import numpy as np
import pytest
from learning import ARMS, GRID, follows, student
from sb3_contrib import MaskablePPO
from stable_baselines3 import DQN, PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.vec_env import DummyVecEnv

import llf_teacher  # noqa: F401  (registers the environments)

PPOS = {"n_steps": 256, "batch_size": 64, "learning_rate": 3e-3}
DQNS = {"learning_starts": 100, "train_freq": 2, "learning_rate": 2e-3, "target_update_interval": 200}


def choices(model):
    return lambda observation: model.predict(observation, deterministic=True)[0]


def test_their_own_check_passes():
    check_env(student())
    check_env(student(ARMS))


@pytest.mark.parametrize(
    ("make", "settings", "id", "gamma"), [(PPO, PPOS, GRID, 0.8), (DQN, DQNS, GRID, 0.8), (PPO, PPOS, ARMS, 0.0)]
)
def test_students_learn_to_follow_advice(make, settings, id, gamma):
    """Which nobody has told them to; by chance they follow one piece of four, or of ten."""
    model = make("MlpPolicy", student(id), gamma=gamma, seed=0, device="cpu", **settings)
    model.learn(4096)
    assert follows(choices(model), id) > 0.6


def teachers_seat():
    """Silence is best, since each thing said costs as much as success is worth."""
    return gymnasium.make("teacher/gridworld-v0", feedback_type="fp+fn", cost=1.0, max_turns=10)


def returned(act):
    """The mean return, and whether nothing was said that could not be."""
    env, total = teachers_seat(), 0.0
    for seed in range(20):
        observation, info = env.reset(seed=seed)
        done = False
        while not done:
            observation, reward, terminated, truncated, info = env.step(act(observation, env.unwrapped.action_masks()))
            assert info["trimmed"] == 0
            total += reward
            done = terminated or truncated
    return total / 20


def test_a_teacher_learns_what_words_cost():
    rng = np.random.default_rng(0)
    by_chance = returned(lambda observation, mask: int(rng.choice(np.flatnonzero(mask))))
    envs = DummyVecEnv([teachers_seat] * 2)
    model = MaskablePPO("MultiInputPolicy", envs, n_steps=128, batch_size=64, learning_rate=3e-3, seed=0, device="cpu")
    model.learn(3072)

    def act(observation, mask):
        return int(model.predict(observation, action_masks=mask, deterministic=True)[0])

    assert by_chance < -5
    assert returned(act) > -1
