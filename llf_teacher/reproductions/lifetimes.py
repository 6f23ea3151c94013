"""Lifetimes, for several rows: a student learns one world in many episodes with a teacher."""

from typing import Any

import numpy as np

from llf_teacher.gym import TeacherEnv
from pz_envs.subject import Subject
from teachers.atoms import HN, HP, Utterance


def live(
    env_id: str | Subject, *, student: str, teacher: str, episodes: int, turns: int, seed: int, **options: Any
) -> list[float]:
    """Play a lifetime in one world, whose episodes begin in the same state.

    Args:
        env_id: the environment.
        student: its spec, with `forget=False`.
        teacher: the personality's spec.
        episodes: number of episodes.
        turns: greatest number of each.
        seed: of the world, the teacher and the student.
        options: of the world.

    Returns:
        The regret of each episode, in the family's unit; then the number of verdicts (hp and hn).
    """
    env = TeacherEnv(
        env_id,
        student=student,
        speech="message",
        episodes=episodes,
        max_turns=turns,
        cost=0.0,
        teacher_reward="student_progress",
        **options,
    )
    policy = env.family.make_teacher(env.session.world, teacher)
    policy.reset(np.random.default_rng(seed))
    observation, info = env.reset(seed=seed)
    regrets, verdicts, done = [0.0], 0, False
    while not done:
        said = policy.act(observation, info)
        if isinstance(said, Utterance):
            verdicts += sum(atom.kind in (HP, HN) for atom in said.atoms)
        observation, reward, terminated, truncated, info = env.step(said)
        done = terminated or truncated
        regrets[-1] -= float(reward)
        if info["moment"].turn == 0 and not done:
            regrets.append(0.0)
    return [*regrets, float(verdicts)]
