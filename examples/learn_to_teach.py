"""A teacher that learned when to advise: maskable PPO in the teacher's seat, against heuristics at an equal budget.

The student learns a house by tabular Q-learning in a lifetime of episodes; the teacher may advise one action in a few
turns of that lifetime, sees numbers only, and is paid by the student's progress. Prints a table. Needs the extra
`learn`:

    python examples/learn_to_teach.py --steps 600000 --seeds 100
"""

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor

import gymnasium
import numpy as np
import torch
from sb3_contrib import MaskablePPO
from sb3_contrib.common.wrappers import ActionMasker
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
from teaching_on_a_budget import SETTINGS, TEACHERS, Setting, lifetime

import llf_teacher
from llf_teacher.studies.statistics import mean_interval, paired_difference

SETTING = SETTINGS[0]._replace(episodes=30, turns=40, budget=8)
HELD_OUT = 1_000_000
"""The comparison has seeds from here on, which no training environment has."""
_ENVS = 8


def seat(setting: Setting) -> gymnasium.Env:
    """The teacher's seat over a lifetime, with advice as the only kind: speak or be silent."""
    env = llf_teacher.TeacherEnv(
        setting.id,
        student=setting.student,
        episodes=setting.episodes,
        max_turns=setting.turns,
        feedback_type="fp",
        budget=setting.budget,
        cost=0.0,
        teacher_reward="student_progress",
        announce=True,
    )
    numbers = gymnasium.wrappers.FilterObservation(env, ["features", "lifetime"])
    return ActionMasker(numbers, lambda wrapped: wrapped.unwrapped.action_masks())


def learner(setting: Setting, seed: int) -> MaskablePPO:
    """An untrained teacher."""
    envs = VecNormalize(DummyVecEnv([lambda: seat(setting)] * _ENVS), norm_obs=False, gamma=0.999)
    envs.seed(seed)
    return MaskablePPO(
        "MultiInputPolicy",
        envs,
        n_steps=1024,
        batch_size=1024,
        gamma=0.999,
        gae_lambda=0.98,
        ent_coef=0.01,
        learning_rate=1e-3,
        seed=seed,
        device="cpu",
    )


def accompanied(model: MaskablePPO, setting: Setting, seeds: Sequence[int]) -> np.ndarray:
    """The student's regret per episode in a lifetime with this teacher, one a seed."""
    regrets = []
    for seed in seeds:
        env = seat(setting)
        observation, _ = env.reset(seed=seed)
        regret, done = 0.0, False
        while not done:
            action, _ = model.predict(observation, action_masks=env.action_masks(), deterministic=True)
            observation, reward, terminated, truncated, _ = env.step(int(action))
            regret -= float(reward)
            done = terminated or truncated
        regrets.append(regret / setting.episodes)
    return np.array(regrets)


def compare(areas: dict[str, np.ndarray], learned: str) -> None:
    """Print regret per episode, and what the learned teacher saves beside each other one."""
    print("| teacher | regret per episode | the learned one's is less by | p |")
    print("|---|---|---|---|")
    for teacher, area in areas.items():
        estimate, gain = mean_interval(area), paired_difference(area, areas[learned])
        print(
            f"| {teacher} | {estimate.mean:.2f} [{estimate.low:.2f}, {estimate.high:.2f}] | {gain.estimate.mean:.2f} "
            f"[{gain.estimate.low:.2f}, {gain.estimate.high:.2f}] | {gain.p:.4f} |"
        )


def heuristic(teacher: str, setting: Setting, seeds: Sequence[int], mapped: Callable[..., object]) -> np.ndarray:
    """The same with a teacher of `teaching_on_a_budget.py`."""
    lives = mapped(lifetime, [setting] * len(seeds), [teacher] * len(seeds), seeds)
    return np.array(list(lives)).mean(axis=1)  # type: ignore[call-overload]


def main() -> None:
    """Train, and compare on held-out seeds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=600_000, help="turns of the teacher to learn from")
    parser.add_argument("--seeds", type=int, default=100, help="lifetimes to compare on")
    parser.add_argument("--seed", type=int, default=0, help="of the training")
    parser.add_argument("--episodes", type=int, default=SETTING.episodes, help="of a lifetime")
    parser.add_argument("--save", help="file for the trained teacher")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    setting = SETTING._replace(episodes=arguments.episodes)
    seeds = range(HELD_OUT, HELD_OUT + arguments.seeds)
    model = learner(setting, arguments.seed)
    areas = {"untrained policy": accompanied(model, setting, seeds)}
    model.learn(arguments.steps, progress_bar=True)
    if arguments.save:
        model.save(arguments.save)
    areas["learned"] = accompanied(model, setting, seeds)
    with ProcessPoolExecutor() as pool:
        for teacher in TEACHERS:
            areas[teacher] = heuristic(teacher, setting, seeds, pool.map)
    print(f"\n{setting.id}: {setting.episodes} episodes, {setting.budget} pieces of advice, {arguments.steps} steps\n")
    compare(areas, "learned")


if __name__ == "__main__":
    main()
