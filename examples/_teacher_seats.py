"""Teachers' seats over lifetimes in arrays: what teachers that learn see, and what students waste with them.

`learn_to_teach.py`, `learn_by_budget.py`, `search_a_teacher.py` and `beside_a_rule.py` share this module.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from teaching_on_a_budget import SETTINGS, Setting

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS

SETTING = SETTINGS[0]._replace(episodes=30, turns=40, budget=8, world={"min_goal_dist": 6})
"""Eight pieces of advice for treasures that are six moves away and more: not enough to show the way twice."""
TRIAL = 2_000_000
"""First seed of the lifetimes that choose among teachers; no training environment has them."""
ADVICE = 0b01000
"""fp among the kinds."""
MISTAKE = FIELDS.index("mistake")
_NEAR = 4  # moves
_WAY = FIELDS.index("way")
Policy = Callable[[np.ndarray], np.ndarray | bool]
"""What rows see, float32 (rows, 14), to whether to speak, bool (rows,)."""


def keywords(setting: Setting) -> dict[str, Any]:
    """The arguments of a teacher's seat over lifetimes, with advice as the only kind."""
    return {
        "student": setting.student,
        "episodes": setting.episodes,
        "max_turns": setting.turns,
        "feedback_type": "fp",
        "budget": setting.budget,
        "cost": 0.0,
        "teacher_reward": "student_progress",
        "announce": True,
        "vary": setting.vary,
        **setting.world,
    }


def look(observation: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The 14 numbers that a seat sees, or each row, and whether a mistake is announced that it may correct."""
    seen = np.concatenate([observation["features"], observation["lifetime"]], axis=-1)
    return seen, (observation["lifetime"][..., MISTAKE] > 0) & (observation["action_mask"][..., ADVICE] > 0)


class Seats:
    """Teachers' seats over lifetimes in arrays; to decide is whether to correct an announced mistake."""

    def __init__(self, setting: Setting, seeds: Sequence[int], pool: int = 16_384) -> None:
        """Lifetimes of these seeds, and further ones where they end, in houses of a pool of this size."""
        pooled = {"pool": pool} if setting.id == SETTING.id else {}
        self.env = llf_teacher.TeacherVectorEnv(setting.id, len(seeds), **keywords(setting), **pooled)
        self._look(self.env.reset(seed=list(seeds))[0])

    def _look(self, observation: Mapping[str, np.ndarray]) -> None:
        self.seen, decides = look(observation)
        """What each row sees."""
        self.choosing = np.flatnonzero(decides)
        """The rows in which there is something to decide."""

    def step(self, speaks: np.ndarray | bool) -> tuple[np.ndarray, np.ndarray]:
        """A turn in all rows; the choosing ones speak or not. Rewards, and which lifetimes have ended."""
        actions = np.zeros(self.env.num_envs, np.int64)
        actions[self.choosing] = np.where(speaks, ADVICE, 0)
        observation, reward, terminated, truncated, _ = self.env.step(actions)
        self._look(observation)
        return reward, terminated | truncated


def near_mistakes(others: float = 0.0, moves: int = _NEAR) -> Policy:
    """Correct the mistakes that are made near the treasure, and a share of the others."""
    rng = np.random.default_rng(0)
    return lambda seen: (seen[:, 5 + _WAY] <= moves / (moves + 4)) | (rng.random(len(seen)) < others)


def accompanied(policy: Policy, setting: Setting, seeds: Iterable[int]) -> np.ndarray:
    """The student's regret per episode in a lifetime with this teacher, one a seed."""
    return lived(Seats(setting, list(seeds), pool=1), lambda seen, _: policy(seen), setting)


def lived(seats: Seats, policy: Callable[[np.ndarray, np.ndarray], np.ndarray | bool], setting: Setting) -> np.ndarray:
    """The student's regret per episode in each of these lifetimes, by a policy of what rows see and their numbers."""
    regrets = np.zeros(seats.env.num_envs)
    living = np.ones(seats.env.num_envs, bool)
    while living.any():  # rows that have ended go on with other lifetimes, which do not count
        rows = seats.choosing
        reward, ended = seats.step(policy(seats.seen[rows], rows))
        regrets -= np.where(living, reward, 0)
        living &= ~ended
    return regrets / setting.episodes
