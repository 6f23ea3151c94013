"""SuperSuit: a class of students who share what they learn, and students whose observations have texts."""

import numpy as np
import supersuit
from learning import ARMS, follows
from stable_baselines3 import PPO
from stable_baselines3.common.utils import set_random_seed

from llf_teacher.registry import PREFIX, entry
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import Attention, SayAll
from pz_envs.seats import TEACHER


def test_a_class_learns_to_follow_advice():
    """Four students in worlds of their own, one policy; all stay until the end, since the task is repeated."""
    family, options = entry(ARMS).family, entry(ARMS).options
    settings = {"students": 4, "attention": 4, "speech": "kinds", "feedback_type": "fp", "numbers": True}
    aec = family.raw_env(seating="classroom", **settings, **options)
    seats = ParallelSeats(aec, {TEACHER: Attention()})
    seats.reset(seed=0)  # here, since SuperSuit's vectors for stable-baselines3 take no seed; the streams go on
    set_random_seed(0)
    single = supersuit.pettingzoo_env_to_vec_env_v1(seats)
    envs = supersuit.concat_vec_envs_v1(single, 2, base_class="stable_baselines3")
    model = PPO("MlpPolicy", envs, n_steps=64, batch_size=64, learning_rate=5e-3, gamma=0.0, device="cpu")
    model.learn(2048)
    assert model.num_timesteps == 2048
    assert follows(lambda observation: model.predict(observation, deterministic=True)[0], ARMS) > 0.6


def test_texts_go_through_vectors():
    aec = entry(f"{PREFIX}gridworld-v0").family.raw_env(speech="kinds")
    single = supersuit.pettingzoo_env_to_vec_env_v1(ParallelSeats(aec, {TEACHER: SayAll()}))
    envs = supersuit.concat_vec_envs_v1(single, 4, base_class="gymnasium")
    observations, _ = envs.reset(seed=7)
    assert all(observations["instruction"])
    observations, *_ = envs.step(np.arange(4))
    assert len(set(observations["feedback"])) == 4
