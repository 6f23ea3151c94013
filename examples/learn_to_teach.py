"""A teacher that learned when to advise: maskable PPO in the teacher's seat, against heuristics at an equal budget.

The student learns a house by tabular Q-learning in a lifetime of episodes; the teacher has a few pieces of advice for
that lifetime, sees numbers only, and is paid by the student's progress. Prints a table and draws how the teacher got
there. Needs the extra `learn`:

    python examples/learn_to_teach.py --steps 600000 --seeds 200 --plot docs/learn-to-teach.png
"""

import argparse
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from teaching_on_a_budget import SETTINGS, TEACHERS, Setting, lifetime

import llf_teacher
from llf_teacher.gym.lifetime import FIELDS
from llf_teacher.studies.statistics import mean_interval, paired_difference

try:
    import torch
    from sb3_contrib import MaskablePPO
    from stable_baselines3.common.running_mean_std import RunningMeanStd
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize
except ModuleNotFoundError as error:
    raise SystemExit(f'{error}; install it by: pip install -e ".[learn]" -c constraints.txt') from None

SETTING = SETTINGS[0]._replace(episodes=30, turns=40, budget=8, world={"min_goal_dist": 6})
"""Eight pieces of advice for treasures that are six moves away and more: not enough to show the way twice."""
TRIAL, HELD_OUT = 2_000_000, 1_000_000
"""First seeds of the lifetimes that choose among trained teachers, and that compare the chosen one; no training
environment has them.
"""
_ENVS, _TRIALS, _STAGES = 8, 60, 10
_NEAR = 4  # moves
_RETICENCE = 3.0  # log-odds of silence at first
_MISTAKE, _WAY = FIELDS.index("mistake"), FIELDS.index("way")
Policy = Callable[[Mapping[str, Any], np.ndarray], int]


class Correcting(gymnasium.Wrapper):
    """A step is a decision: to let a mistake happen that has been announced, or to spend a piece of advice on it.

    Until the next decision, or the end of the lifetime, the teacher is silent. The reward is that of all turns since.
    """

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        """Begin a lifetime; what the student loses before the first decision belongs to the first step's reward."""
        observation, info = self.env.reset(**kwargs)
        observation, self._owed, terminated, truncated, info = self._proceed(observation, 0.0, False, False, info)
        if terminated or truncated:  # without a mistake there is nothing to decide
            return self.reset()
        return observation, info

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Speak or not."""
        observation, reward, *rest = self._proceed(*self.env.step(action))
        owed, self._owed = self._owed, 0.0
        return observation, reward + owed, *rest

    def _proceed(
        self, observation: Any, reward: Any, terminated: bool, truncated: bool, info: dict[str, Any]
    ) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Be silent until there is something to decide."""
        while not (terminated or truncated or (observation["lifetime"][_MISTAKE] and self.action_masks()[1:].any())):
            observation, more, terminated, truncated, info = self.env.step(0)
            reward += more
        return observation, reward, terminated, truncated, info

    def action_masks(self) -> np.ndarray:
        """Silence, and advice while there is some left."""
        return self.env.unwrapped.action_masks()


def seat(setting: Setting) -> gymnasium.Env:
    """The teacher's seat over a lifetime, with advice as the only kind."""
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
        **setting.world,
    )
    return Correcting(gymnasium.wrappers.FilterObservation(env, ["features", "lifetime"]))


def learner(setting: Setting, seed: int) -> MaskablePPO:
    """An untrained teacher: it seldom speaks, so that what it says at first is spread over the whole lifetime."""
    envs = VecNormalize(DummyVecEnv([lambda: seat(setting)] * _ENVS), gamma=1.0)
    envs.seed(seed)
    model = MaskablePPO(
        "MultiInputPolicy",
        envs,
        n_steps=1024,
        batch_size=2048,
        gamma=1.0,  # advice pays off over many episodes
        gae_lambda=0.95,
        ent_coef=0.01,
        learning_rate=5e-4,
        seed=seed,
        device="cpu",
    )
    with torch.no_grad():
        model.policy.action_net.bias[0] = _RETICENCE
    return model


def policy_of(model: MaskablePPO, explores: bool = False) -> Policy:
    """What a teacher does, by chance as in training or by what it thinks best."""
    scale = model.get_vec_normalize_env()

    def act(observation: Mapping[str, Any], mask: np.ndarray) -> int:
        seen = scale.normalize_obs(observation)
        return int(model.predict(seen, action_masks=mask, deterministic=not explores)[0])

    return act


def near_mistakes(others: float = 0.0) -> Policy:
    """Correct the mistakes that are made near the treasure, and a share of the others."""
    rng = np.random.default_rng(0)

    def act(observation: Mapping[str, Any], mask: np.ndarray) -> int:
        near = observation["lifetime"][_WAY] <= _NEAR / (_NEAR + 4)
        return int(np.flatnonzero(mask)[-1]) if near or rng.random() < others else 0

    return act


def accompanied(policy: Policy, setting: Setting, seeds: Iterable[int]) -> np.ndarray:
    """The student's regret per episode in a lifetime with this teacher, one a seed."""
    env = seat(setting)
    regrets = []
    for seed in seeds:
        observation, _ = env.reset(seed=seed)
        regret, done = 0.0, False
        while not done:
            observation, reward, terminated, truncated, _ = env.step(policy(observation, env.action_masks()))
            regret -= float(reward)
            done = terminated or truncated
        regrets.append(regret / setting.episodes)
    return np.array(regrets)


class Stage(NamedTuple):
    """A teacher on its way."""

    decisions: int
    """In training."""
    regret: float
    """Per episode, on trial."""
    weights: Mapping[str, torch.Tensor]
    scales: Mapping[str, RunningMeanStd]


def train(model: MaskablePPO, setting: Setting, steps: int) -> list[Stage]:
    """Train in stages; the model becomes the best of them."""
    scale = model.get_vec_normalize_env()
    stages = []
    count = max(1, min(_STAGES, steps // (model.n_steps * model.n_envs)))  # it learns from so many at once
    for _ in range(count):
        model.learn(steps // count, reset_num_timesteps=False, progress_bar=True)
        regret = accompanied(policy_of(model), setting, range(TRIAL, TRIAL + _TRIALS)).mean()
        weights = {name: values.clone() for name, values in model.policy.state_dict().items()}
        scales = {name: each.copy() for name, each in scale.obs_rms.items()}
        stages.append(Stage(model.num_timesteps, regret, weights, scales))
        print(f"{model.num_timesteps} decisions: regret per episode {regret:.2f} on trial", flush=True)
    best = min(stages, key=lambda stage: stage.regret)
    model.policy.load_state_dict(best.weights)
    scale.obs_rms = dict(best.scales)
    return stages


def heuristic(teacher: str, setting: Setting, seeds: Iterable[int], mapped: Callable[..., Any]) -> np.ndarray:
    """The same with a teacher of `teaching_on_a_budget.py`."""
    seeds = list(seeds)
    return np.array(list(mapped(lifetime, [setting] * len(seeds), [teacher] * len(seeds), seeds))).mean(axis=1)


def compare(areas: Mapping[str, np.ndarray], learned: str) -> None:
    """Print regret per episode, and what the learned teacher saves beside each other one."""
    print("| teacher | regret per episode | the learned one's is less by | p |")
    print("|---|---|---|---|")
    for teacher, area in areas.items():
        estimate, gain = mean_interval(area), paired_difference(area, areas[learned])
        saved = f"{gain.estimate.mean:.2f} [{gain.estimate.low:.2f}, {gain.estimate.high:.2f}] | {gain.p:.4f}"
        print(
            f"| {teacher} | {estimate.mean:.2f} [{estimate.low:.2f}, {estimate.high:.2f}] | "
            f"{saved if teacher != learned else ' | '} |"
        )


def draw(stages: list[Stage], areas: Mapping[str, np.ndarray], path: str) -> None:
    """How the teacher got better in training, and all teachers on held-out lifetimes, with 95 % intervals."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot([stage.decisions for stage in stages], [stage.regret for stage in stages], marker="o")
    left.set(xlabel="decisions in training", ylabel="regret per episode, on trial", ylim=(0, None))
    names = sorted(areas, key=lambda name: -areas[name].mean())
    for row, name in enumerate(names):
        estimate, color = mean_interval(areas[name]), "C1" if name == "learned" else "C0"
        right.plot((estimate.low, estimate.high), (row, row), color=color, linewidth=2)
        right.plot(estimate.mean, row, "o", color=color)
    right.set(yticks=range(len(names)), yticklabels=names, xlabel="regret per episode, held out", xlim=(0, None))
    figure.savefig(path, dpi=110)


def main() -> None:
    """Train, and compare on held-out seeds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=600_000, help="decisions to learn from")
    parser.add_argument("--seeds", type=int, default=200, help="lifetimes to compare on")
    parser.add_argument("--seed", type=int, default=0, help="of the training")
    parser.add_argument("--episodes", type=int, default=SETTING.episodes, help="of a lifetime")
    parser.add_argument("--save", help="folder for the trained teacher, and for the scales of its observations")
    parser.add_argument("--plot", help="file for the figure")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    setting = SETTING._replace(episodes=arguments.episodes)
    seeds = range(HELD_OUT, HELD_OUT + arguments.seeds)
    model = learner(setting, arguments.seed)
    areas = {"untrained policy": accompanied(policy_of(model, explores=True), setting, seeds)}
    stages = train(model, setting, arguments.steps)
    if arguments.save:
        folder = Path(arguments.save)
        folder.mkdir(parents=True, exist_ok=True)
        model.save(folder / "teacher.zip")
        model.get_vec_normalize_env().save(str(folder / "scales.pkl"))
    areas["learned"] = accompanied(policy_of(model), setting, seeds)
    with ProcessPoolExecutor() as pool:
        for teacher in TEACHERS:
            areas[teacher] = heuristic(teacher, setting, seeds, pool.map)
    areas["near mistakes"] = accompanied(near_mistakes(), setting, seeds)
    areas["near mistakes, half of the others"] = accompanied(near_mistakes(others=0.5), setting, seeds)
    print(f"\n{setting.id}: {setting.episodes} episodes, {setting.budget} pieces of advice\n")
    compare(areas, "learned")
    if arguments.plot:
        draw(stages, areas, arguments.plot)


if __name__ == "__main__":
    main()
