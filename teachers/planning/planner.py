"""The interface of planners, and their result."""

import copy
import random
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, SupportsFloat

import gymnasium
import numpy as np

from teachers.oracle import Oracle
from teachers.phrasebook import Phrases
from worlds.wrapped.position import same, still

_Env = gymnasium.Env[Any, Any]
_TRIAL = 20  # steps


REWARDS = "rewards"
"""The tier of a teacher that states rewards only."""


class PlanningError(ValueError):
    """A planner cannot serve an environment; the message says why, and what would help."""


class RewardsOnlyWarning(UserWarning):
    """No tier of planning serves an environment, so its teacher states rewards only."""


@dataclass(frozen=True)
class Planned:
    """All that a lesson in an environment needs."""

    tier: str
    """A name of `teachers.planning.TIERS`, or `rewards`."""
    why: str
    """What the tier rests on, for people."""
    oracle: type[Oracle[Any, Any]]
    phrases: Phrases
    """The oracle's phrases, or the path of their file."""
    look: Callable[[_Env], Any] | None
    """Reads the hashable key of the current state, which truths have as `seen`; None: truths have the observation."""
    model: Any
    """The knowledge of oracle and claims; see `worlds.wrapped.gym_world.GymWorld.model`."""
    horizon: int | None = None
    """Most actions of the episodes that it serves; None: any number."""
    action_words: Mapping[str, Any] = field(default_factory=dict)
    """Words that name actions; empty: none are known."""
    describe: Callable[[Any], str] | None = None
    """An observation as text; None: plain numbers."""
    success: Callable[..., Any] | None = None
    """Whether a step has solved the task, unless the caller says; see `worlds.wrapped.gym_world.GymWorld`."""
    privileged: bool | None = None
    """Whether the teacher knows more of a state than the student sees; None: unknown."""
    copies: bool = True
    """Whether the oracle restores states of the environment; if not, episodes begin without a copy of it."""
    objective: str = ""
    """The objective of the values, for people; the info of a reset has it."""
    size: str = ""
    """The size of the plan, for people: the number of states, or of roll-outs with their horizon."""
    refused: Mapping[str, str] = field(default_factory=dict)
    """The reasons why higher tiers do not serve, by tier."""


class Planner(ABC):
    """Makes a `Planned` of an environment."""

    @abstractmethod
    def plan(self, env: _Env, turns: int, success: Callable[..., Any] | None = None) -> Planned:
        """Plan for an environment.

        Args:
            env: an environment, which may be reset and stepped.
            turns: most actions of an episode.
            success: whether a step has solved the task; None: the environment or the planner decides.

        Raises:
            PlanningError: it cannot serve the environment.
        """


def stepped(env: _Env, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
    """Take an action.

    Raises:
        PlanningError: the environment raised, or its reward is no number.
    """
    try:
        observation, reward, terminated, truncated, info = env.step(action)
    except Exception as error:
        raise PlanningError(
            f"the environment raised {error!r} after action {action} in a state that was tried"
        ) from error
    if not _is_number(reward):
        raise PlanningError(f"rewards must be numbers, got {reward!r} after action {action}")
    return observation, reward, bool(terminated), bool(truncated), info


def _is_number(reward: Any) -> bool:
    return isinstance(reward, SupportsFloat) and np.ndim(reward) == 0  # type: ignore[arg-type]  # any object has one


def why_unlike(env: _Env) -> str:
    """Why copies of an environment do not continue like the original; resets may show it."""
    first = still(env.reset(seed=0)[0])
    if any(not same(first, still(env.reset(seed=0)[0])) for _ in range(_TRIAL)):
        return "reset(seed=0) does not give the same each time; let the seed decide all that it draws"
    return "its copies do not continue like the original"


def shared_draws() -> Any:
    """The states of the global generators of `random` and NumPy."""
    return random.getstate(), np.random.get_state()  # noqa: NPY002 (only looked at)


def check_own_draws(env: _Env) -> None:
    """Check by random play that steps do not draw from global generators, which copies would share.

    Raises:
        PlanningError: they do.
    """
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    env.reset(seed=0)
    for _ in range(_TRIAL):
        before = shared_draws()
        _, _, terminated, truncated, _ = stepped(env, space.sample())
        if not same(before, shared_draws()):
            raise PlanningError(
                "the environment draws from the generators that all of Python or NumPy share, so that copies of it "
                "change what others draw; let it draw from its np_random"
            )
        if terminated or truncated:
            env.reset(seed=0)


def check_steps(env: _Env) -> None:
    """Check that the environment can be reset and stepped.

    Raises:
        PlanningError: it raised, or its result is not what Gymnasium demands.
    """
    try:
        space = copy.deepcopy(env.action_space)
        space.seed(0)
        env.reset(seed=0)
        _, reward, terminated, _, _ = env.step(space.sample())
        if not _is_number(reward):
            raise TypeError(f"the reward must be a number, got {reward!r}")
        bool(terminated)
    except Exception as error:
        raise PlanningError(
            f"the environment cannot be reset and stepped as Gymnasium demands: {error!r}; try "
            "gymnasium.utils.env_checker.check_env(env)"
        ) from error
