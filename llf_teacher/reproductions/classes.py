"""Lifetimes in arrays, for several rows: many Q-learners at once, each with a teacher that follows a rule."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from llf_teacher.gym import TeacherVectorEnv
from llf_teacher.gym.lifetime_statistics import FIELDS, HALF, NEAR
from worlds.batches import Bools, Floats

LIFETIMES = 50
"""Lifetimes of a class; each seed stands for a class."""
STUDENT = "q_learning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)"
"""Takes the advised action, and learns from its result."""
ADVICE = 0b01000
"""The teacher's choice of `fp` alone."""
COLUMN = {name: number for number, name in enumerate(FIELDS)}
"""Column of each number in `lifetime`."""


class Glance(NamedTuple):
    """What a teacher observes of each lifetime, one value per row."""

    importance: Floats
    """Moves between the best and the worst next action."""
    mistake: Bools
    """Whether the student has announced an action that is not the best."""
    erred: Bools
    """Whether its last action was not the best."""
    before: Floats
    """Importance of that action; 0 at an opening."""
    way: Floats
    """Moves from here to the treasure."""
    rng: np.random.Generator


def teacher_env(
    id: str, count: int, *, episodes: int, turns: int, budget: int, student: str = STUDENT, **options: Any
) -> TeacherVectorEnv:
    """Lifetimes side by side, each in its own world; the teacher's reward is the student's progress.

    Args:
        id: the environment.
        count: of the lifetimes.
        episodes: of a lifetime.
        turns: greatest number of an episode.
        budget: pieces of advice in a lifetime, at least 1.
        student: its spec.
        options: of the world.
    """
    return TeacherVectorEnv(
        id,
        count,
        student=student,
        episodes=episodes,
        max_turns=turns,
        feedback_type="fp",
        budget=budget,
        cost=0.0,
        teacher_reward="student_progress",
        announce=True,
        options={"pool": 1},  # rows that have ended are ignored
        **options,
    )


def moves_left(life: Floats) -> Floats:
    """Moves from here to the treasure, one per row of `lifetime`, the teacher's observation."""
    share = life[:, COLUMN["way"]]
    return np.rint(HALF * share / (1 - share))


Rule = Callable[[Glance], Bools]
"""Gives per row whether to spend a piece of advice."""


class Lives(NamedTuple):
    """The outcome of a class: means over its lifetimes."""

    regret: float
    """Per episode."""
    said: float
    """Pieces of advice."""
    greatest: float
    """Share of turns with the greatest possible importance."""


def accompanied(
    id: str, rule: Rule, *, seed: int, episodes: int, turns: int, budget: int, student: str = STUDENT, **options: Any
) -> Lives:
    """Play a class of lifetimes, each in its own world, with a teacher that advises by a rule.

    Args:
        id: the environment.
        rule: whether to advise.
        seed: of the class; different ones have no world in common.
        episodes: of a lifetime.
        turns: greatest number of an episode.
        budget: pieces of advice in a lifetime, at least 1.
        student: its spec.
        options: of the world.
    """
    env = teacher_env(id, LIFETIMES, episodes=episodes, turns=turns, budget=budget, student=student, **options)
    observation, _ = env.reset(seed=list(range(seed * LIFETIMES, (seed + 1) * LIFETIMES)))
    living, regret, said = np.ones(LIFETIMES, bool), np.zeros(LIFETIMES), np.zeros(LIFETIMES)
    most, before = env.oracle.oracle.max_importance, np.zeros(LIFETIMES)
    turn_count = at_most = 0
    rng = np.random.default_rng(seed)
    while living.any():
        features, life = observation["features"], observation["lifetime"].astype(float)
        importance = features[:, 2].astype(float)
        opening = features[:, 0] == 0
        seen = Glance(
            importance=importance,
            mistake=life[:, COLUMN["mistake"]] > 0,
            erred=~opening & (life[:, COLUMN["optimal"]] == 0),
            before=np.where(opening, 0.0, before),
            way=moves_left(life),
            rng=rng,
        )
        speaks = rule(seen) & (observation["action_mask"][:, ADVICE] > 0) & living
        acts = living & (features[:, 4] == 0)
        turn_count += int(acts.sum())
        at_most += int((importance[acts] >= most - NEAR).sum())
        before = importance
        observation, reward, terminated, truncated, _ = env.step(np.where(speaks, ADVICE, 0))
        said += speaks
        regret -= np.where(living, reward, 0.0)
        living &= ~(terminated | truncated)
    env.close()
    return Lives(float(regret.mean()) / episodes, float(said.mean()), at_most / turn_count)
