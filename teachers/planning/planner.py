"""The interface of planners, and what they find out about an environment."""

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
"""The tier of a teacher who says what was paid, and no more."""


class PlanningError(ValueError):
    """Raised by a planner that cannot serve an environment; it says why, and what would help."""


class RewardsOnlyWarning(UserWarning):
    """No tier of planning serves an environment, so that its teacher says what was paid, and no more."""


@dataclass(frozen=True)
class Planned:
    """What makes an environment a lesson."""

    tier: str
    """How much is known: a name of `teachers.planning.TIERS`, or `rewards`."""
    why: str
    """What the tier rests on, for people."""
    oracle: type[Oracle[Any, Any]]
    phrases: Phrases
    """The oracle's phrases, or the path of their file."""
    look: Callable[[_Env], Any] | None
    """Reads the key of the current state, hashable, which truths show as `seen`; None: these show the observation."""
    model: Any
    """What oracle and claims know of the environment; see `worlds.wrapped.gym_world.GymWorld.model`."""
    horizon: int | None = None
    """Most actions of the episodes for which it holds; None: any number."""
    action_words: Mapping[str, Any] = field(default_factory=dict)
    """Words that name actions; empty: none are known."""
    describe: Callable[[Any], str] | None = None
    """An observation as text; None: plain numbers."""
    success: Callable[..., Any] | None = None
    """Whether a step has solved the task, where the caller has not said; see `worlds.wrapped.gym_world.GymWorld`."""
    privileged: bool | None = None
    """Whether the teacher knows more of a state than the student sees; None: that is not known."""
    copies: bool = True
    """Whether the oracle goes to states of the environment; if not, episodes begin without a copy of it."""
    objective: str = ""
    """What values are of, for people; lessons have it in the info of a reset."""
    size: str = ""
    """How much is planned, for people: so many states, or roll-outs with their greatest length."""
    refused: Mapping[str, str] = field(default_factory=dict)
    """Why higher tiers do not serve, by their names."""


class Planner(ABC):
    """Makes a `Planned` of an environment."""

    @abstractmethod
    def plan(self, env: _Env, turns: int, success: Callable[..., Any] | None = None) -> Planned:
        """Find out what can be known.

        Args:
            env: an environment, which may be reset and stepped.
            turns: most actions of an episode.
            success: whether a step has solved the task; None: what the environment says, or the planner knows.

        Raises:
            PlanningError: the environment is none that it can serve.
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
    """Why copies of an environment do not continue like the original, as far as resets show."""
    first = still(env.reset(seed=0)[0])
    if any(not same(first, still(env.reset(seed=0)[0])) for _ in range(_TRIAL)):
        return "reset(seed=0) does not give the same each time; let the seed decide all that it draws"
    return "its copies do not continue like the original"


def shared_draws() -> Any:
    """The state of the generators that `random` and NumPy share."""
    return random.getstate(), np.random.get_state()  # noqa: NPY002 (only looked at)


def check_own_draws(env: _Env) -> None:
    """Play at random, to see whether steps draw from what copies of the environment do not hold.

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
    """Take a step, to see whether the environment can do that.

    Raises:
        PlanningError: it raised, or gave something else than Gymnasium demands.
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
