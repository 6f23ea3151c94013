"""LLF-Bench's `agents.utils`: helpers to run its agents."""

import random
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

__all__ = ["ReplayBuffer", "evaluate_agent", "extract_action", "extract_int", "print_color", "rollout", "set_seed"]

_COLORS = {"red": 91, "green": 92, "yellow": 93, "blue": 94, "magenta": 95, "cyan": 96}


class ReplayBuffer:
    """The last records, each a dict.

    Args:
        buffer_size: greatest number of records.
    """

    def __init__(self, buffer_size: int) -> None:
        self.buffer_size = buffer_size
        self.buffer: list[dict[str, Any]] = []

    def reset(self) -> None:
        """Delete all records."""
        self.buffer = []

    def append(self, **record: Any) -> None:
        """Add a record; the oldest is deleted if there are too many."""
        self.buffer = [*self.buffer, record][-self.buffer_size :]

    def update(self, **changes: Any) -> None:
        """Change the last record, if there is one."""
        if self.buffer:
            self.buffer[-1].update(changes)

    def __len__(self) -> int:
        return len(self.buffer)

    def __getitem__(self, item: Any) -> Any:
        return self.buffer[item]


def print_color(message: Any, color: str | None = None, logger: Any = None) -> None:
    """Print in a colour, if it is known, and log the message if there is a logger."""
    print(f"\033[{_COLORS.get(color or '', 0)}m{message}\033[0m")  # noqa: T201 (its purpose)
    if logger is not None:
        logger.log(message)


def set_seed(seed: int, env: Any = None) -> None:
    """Seed the global generators, for agents that draw from them; no environment here does."""
    random.seed(seed)
    np.random.seed(seed)  # noqa: NPY002 (its purpose)


def extract_int(txt: str) -> list[int]:
    """The words of a text that are whole numbers."""
    return [int(word) for word in txt.split() if word.isdigit()]


def extract_action(response: str, n_actions: int | None, separator: str = "#") -> Any:
    """The text between separators, or with `n_actions` the first number in it that is an action.

    Without such a number the unchanged response is returned; environments treat it as a text that is not an action.
    """
    parts = response.split(separator)
    if len(parts) < 2:
        return response
    if n_actions is None:
        return parts[1]
    return next((number for number in extract_int(parts[1]) if number < n_actions), response)


def rollout(
    agent: Any,
    env: gymnasium.Env[Any, Any],
    *,
    horizon: int,
    log_data: bool = False,
    sparse_reward: bool = False,
    seed: int | None = None,
) -> tuple[float, dict[str, list[Any]]]:
    """One episode of an agent with `reset(docstring)` and `act(observation, feedback)`.

    Args:
        agent: the agent.
        env: an environment that gives instructions and feedback.
        horizon: greatest number of turns; success also ends the episode.
        log_data: whether all steps are logged.
        sparse_reward: whether the score is 1 for success, else the sum of rewards.
        seed: of the reset.

    Returns:
        The score, and lists `observations`, `actions`, `rewards`, `dones` and `infos`.
    """
    observation, info = env.reset(seed=seed)
    agent.reset(observation["instruction"])
    data: dict[str, list[Any]] = {"observations": [observation], "actions": [], "rewards": [], "dones": [], "infos": []}
    total = 0.0
    for _ in range(horizon):
        action = agent.act(observation["observation"], observation["feedback"])
        observation, reward, terminated, truncated, info = env.step(action)
        done = terminated or truncated or info["success"]
        total += float(reward)
        if log_data:
            for values, value in zip(data.values(), (observation, action, reward, done, info), strict=True):
                values.append(value)
        if done:
            break
    return float(info["success"]) if sparse_reward else total, data


def evaluate_agent(
    agent: Any,
    env: gymnasium.Env[Any, Any],
    *,
    horizon: int,
    n_episodes: int,
    log_data: bool = False,
    n_workers: int = 1,
    sparse_reward: bool = False,
    seed: int | None = None,
) -> npt.NDArray[np.float64] | tuple[npt.NDArray[np.float64], list[dict[str, list[Any]]]]:
    """The scores of several episodes, see `rollout`; with `log_data` also their data. Only the first is seeded.

    Raises:
        ValueError: `n_workers` is not 1.
    """
    if n_workers != 1:
        raise ValueError(f"n_workers must be 1, got {n_workers}; a study plays in several, see docs/studies.md")
    results = [
        rollout(agent, env, horizon=horizon, log_data=log_data, sparse_reward=sparse_reward, seed=first)
        for first in (seed, *[None] * (n_episodes - 1))
    ]
    scores = np.array([score for score, _ in results])
    return (scores, [data for _, data in results]) if log_data else scores
