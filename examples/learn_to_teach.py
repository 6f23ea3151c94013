"""A teacher that learned when to advise: PPO in the teacher's seat, against heuristics at an equal budget.

The student learns a house by tabular Q-learning in a lifetime of episodes; the teacher has a few pieces of advice for
that lifetime, sees numbers only, and is paid by the student's progress. Many lifetimes are lived at once, in arrays.
Prints a table and draws how the teacher got there. Needs the extra `learn`:

    python examples/learn_to_teach.py --steps 1000000 --seeds 200 --plot docs/learn-to-teach.png
"""

import argparse
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from _teacher_seats import SETTING, TRIAL, Policy, Seats, accompanied, near_mistakes
from gymnasium import Env
from gymnasium.spaces import Box, Discrete
from rich.console import Console
from rich.progress import Progress
from teaching_on_a_budget import TEACHERS, Setting, lifetime

from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

try:
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.buffers import RolloutBuffer
    from stable_baselines3.common.logger import Logger
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
except ModuleNotFoundError as error:
    raise SystemExit(f'{error}; install it by: pip install -e ".[learn]" -c constraints-learn.txt') from None

HELD_OUT = 1_000_000
"""First seed of the lifetimes that compare the chosen teacher; no training environment has them."""
_ROWS, _DECISIONS, _TRIALS, _STAGES = 64, 256, 200, 10  # PPO learns from so many decisions of each row at once
_RETICENCE = 3.0  # log-odds of silence at first
_MOVES = 200.0  # a unit of reward, about what a lifetime varies by
_LEAST = 0.05  # deviation: what hardly varies at first may do so later
_SEEN = Box(0, 100, (5 + len(FIELDS),), np.float32)  # `features`, then `lifetime`


class Space(Env):
    """What a decision sees and can be, for a learner that is told of decisions by `Rollouts`."""

    observation_space, action_space = _SEEN, Discrete(2)


class Rollouts:
    """Fills a learner's buffer with the same number of decisions of each row, however far apart they are.

    The reward of a decision is that of all turns until the next one, or until the end of the lifetime.
    """

    def __init__(self, model: PPO, setting: Setting, seed: int, rows: int = _ROWS, without: Sequence[int] = ()) -> None:
        """Rows for a training with this seed; `without` are numbers that it does not see."""
        self.model, self.seats = model, Seats(setting, range(seed * rows, (seed + 1) * rows))
        self._rows, self._decisions, self._without = rows, _ROWS * _DECISIONS // rows, list(without)
        spaces = model.observation_space, model.action_space
        rates = {"gae_lambda": model.gae_lambda, "gamma": model.gamma}
        self.buffer = model.rollout_buffer = RolloutBuffer(self._decisions, *spaces, n_envs=rows, **rates)
        self._fresh = np.ones(rows, bool)  # lifetimes without a decision so far

    def collect(self) -> None:
        """Live on until every row has made its decisions; what a row decides beyond them is not learned from."""
        self.buffer.reset()
        self._known = np.zeros(self._rows, np.int64)  # decisions whose reward is known
        self._waiting = np.zeros(self._rows, bool)  # for the reward of a decision
        self._gained = np.zeros(self._rows)
        self._last_values, self._last_ended = torch.zeros(self._rows), np.zeros(self._rows, bool)
        while (self._known < self._decisions).any():
            rows = self.seats.choosing
            reward, ended = self.seats.step(self._decide(rows) if len(rows) else rows > 0)
            self._gained += reward
            self._close(np.flatnonzero(ended), ended=True)
            self._fresh |= ended
        self.buffer.pos, self.buffer.full = self._decisions, True
        self.buffer.compute_returns_and_advantage(self._last_values, self._last_ended)

    def _decide(self, rows: np.ndarray) -> np.ndarray:
        seen = torch.as_tensor(hidden(self.seats.seen[rows], self._without))
        with torch.no_grad():
            actions, values, log_probs = self.model.policy(seen)
        waited = self._waiting[rows]
        self._last_values[rows[waited]] = values[waited].flatten()  # the last one stays
        self._close(rows, ended=False)
        new = self._known[rows] < self._decisions
        into = self._known[rows[new]], rows[new]
        self.buffer.observations[into] = seen[new]
        self.buffer.actions[into] = actions[new, None]
        self.buffer.values[into] = values[new].flatten()
        self.buffer.log_probs[into] = log_probs[new]
        self.buffer.episode_starts[into] = self._fresh[rows[new]]
        self._waiting[rows[new]] = True
        self._gained[rows] = 0
        self._fresh[rows] = False
        return actions.numpy() > 0

    def _close(self, rows: np.ndarray, *, ended: bool) -> None:
        """The reward of what rows have decided is known."""
        rows = rows[self._waiting[rows]]
        self.buffer.rewards[self._known[rows], rows] = self._gained[rows] / _MOVES
        self._known[rows] += 1
        self._waiting[rows] = False
        self._last_ended[rows] = ended


class Scaled(BaseFeaturesExtractor):
    """What is seen, by its mean and deviation in play before training."""

    def __init__(self, space: Box) -> None:
        super().__init__(space, space.shape[0])
        self.register_buffer("mean", torch.zeros(space.shape))
        self.register_buffer("deviation", torch.ones(space.shape))

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        """Scaled."""
        return (seen - self.mean) / self.deviation

    def fit(self, seen: np.ndarray) -> None:
        """Take mean and deviation of these, shape (n, 14)."""
        self.mean.copy_(torch.as_tensor(seen.mean(axis=0)))
        self.deviation.copy_(torch.as_tensor(np.maximum(seen.std(axis=0), _LEAST)))


def learner(seed: int) -> PPO:
    """An untrained teacher: it seldom speaks, so that what it says at first is spread over the whole lifetime."""
    model = PPO(
        "MlpPolicy",
        Space(),
        n_steps=_ROWS * _DECISIONS,
        batch_size=2048,
        gamma=1.0,  # advice pays off over many episodes
        gae_lambda=0.95,
        ent_coef=0.01,
        learning_rate=5e-4,
        policy_kwargs={"features_extractor_class": Scaled},
        seed=seed,
        device="cpu",
    )
    model.set_logger(Logger(None, []))
    with torch.no_grad():
        model.policy.action_net.bias[0] = _RETICENCE
    return model


def hidden(seen: np.ndarray, without: Sequence[int]) -> np.ndarray:
    """The same without some of the numbers, shape (n, 14)."""
    shown = seen.copy()
    shown[:, list(without)] = 0
    return shown


def policy_of(model: PPO, explores: bool = False, without: Sequence[int] = ()) -> Policy:
    """What a teacher does, by chance as in training or by what it thinks best; `without` some of the numbers."""
    return lambda seen: len(seen) > 0 and model.predict(hidden(seen, without), deterministic=not explores)[0] > 0


class Stage(NamedTuple):
    """A teacher on its way."""

    decisions: int
    """In training."""
    regret: float
    """Per episode, on trial."""
    weights: Mapping[str, torch.Tensor]


def train(
    model: PPO, setting: Setting, steps: int, seed: int, rows: int = _ROWS, without: Sequence[int] = ()
) -> list[Stage]:
    """Train in stages; the model becomes the best of them."""
    rollouts, stages = Rollouts(model, setting, seed, rows, without), list[Stage]()
    acts = policy_of(model, without=without)
    updates = -(-steps // (_ROWS * _DECISIONS))
    rollouts.collect()
    model.policy.features_extractor.fit(rollouts.buffer.observations.reshape(-1, *_SEEN.shape))
    ends = {round(updates * (stage + 1) / _STAGES) for stage in range(_STAGES)} - {0}
    with Progress(console=Console(emoji=False, stderr=True)) as progress:
        for update in progress.track(range(1, updates + 1), description="decisions"):
            rollouts.collect()
            model.train()
            if update in ends:
                regret = accompanied(acts, setting, range(TRIAL, TRIAL + _TRIALS)).mean()
                weights = {name: values.clone() for name, values in model.policy.state_dict().items()}
                stages.append(Stage(update * _ROWS * _DECISIONS, regret, weights))
                progress.console.print(f"{stages[-1].decisions} decisions: regret per episode {regret:.2f} on trial")
    model.policy.load_state_dict(min(stages, key=lambda stage: stage.regret).weights)
    return stages


def heuristic(teacher: str, setting: Setting, seeds: Iterable[int], mapped: Callable[..., Any]) -> np.ndarray:
    """The same with a teacher of `teaching_on_a_budget.py`."""
    seeds = list(seeds)
    return np.array(list(mapped(lifetime, [setting] * len(seeds), [teacher] * len(seeds), seeds))).mean(axis=1)


def near_by_budget(setting: Setting, seeds: Sequence[int]) -> None:
    """Print what correcting mistakes within so many moves comes to, and correcting all of them, by the budget."""
    within = range(1, 9)
    print(f"| budget | {' | '.join(map(str, within))} | all |\n|---|{'---|' * (len(within) + 1)}")
    for budget in (2, 4, 8, 16, 32):
        given = setting._replace(budget=budget)
        rules = [*(near_mistakes(moves=moves) for moves in within), near_mistakes(others=1.0)]
        print(
            f"| {budget} | {' | '.join(f'{accompanied(rule, given, seeds).mean():.2f}' for rule in rules)} |",
            flush=True,
        )


def compare(areas: Mapping[str, np.ndarray], learned: str) -> None:
    """Print regret per episode, and what the learned teacher saves beside each other one."""
    print("| teacher | regret per episode | the learned one's is less by | p |")
    print("|---|---|---|---|")
    for teacher, area in areas.items():
        estimate, gain = mean_interval(area), paired_difference(area, areas[learned])
        saved = f"{gain.estimate.text()} | {gain.p:.4f}"
        print(f"| {teacher} | {estimate.text()} | {saved if teacher != learned else ' | '} |")


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
    parser.add_argument("--steps", type=int, default=1_000_000, help="decisions to learn from")
    parser.add_argument("--seeds", type=int, default=200, help="lifetimes to compare on")
    parser.add_argument("--seed", type=int, default=0, help="of the training")
    parser.add_argument("--episodes", type=int, default=SETTING.episodes, help="of a lifetime")
    parser.add_argument("--save", help="file for the trained teacher")
    parser.add_argument("--plot", help="file for the figure")
    parser.add_argument("--near", action="store_true", help="compare rules of nearness by budget, and train nothing")
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    setting = SETTING._replace(episodes=arguments.episodes)
    seeds = range(HELD_OUT, HELD_OUT + arguments.seeds)
    if arguments.near:
        near_by_budget(setting, seeds)
        return
    model = learner(arguments.seed)
    areas = {"untrained policy": accompanied(policy_of(model, explores=True), setting, seeds)}
    began = time.process_time()
    stages = train(model, setting, arguments.steps, arguments.seed)
    print(f"trained on {stages[-1].decisions} decisions in {time.process_time() - began:.0f} s of the processor")
    if arguments.save:
        model.save(Path(arguments.save))
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
