"""What is known of single environments: words of actions and observations, and tables that they do not bring.

One module for each, with what it knows as `KNOWN`.
"""

import enum
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import gymnasium

from teachers.planning.transitions import Transitions

_Env = gymnasium.Env[Any, Any]
State = Callable[[_Env], Hashable]
"""Reads the key of an environment's current state."""

Heuristic = Callable[[_Env], float]
"""Guesses from an environment's current state how many actions are left."""

_MODULES = {
    "gymnasium.envs.box2d.lunar_lander:LunarLander": "lunar_lander",
    "gymnasium.envs.classic_control.acrobot:AcrobotEnv": "acrobot",
    "gymnasium.envs.classic_control.cartpole:CartPoleEnv": "cart_pole",
    "gymnasium.envs.classic_control.mountain_car:MountainCarEnv": "mountain_car",
    "gymnasium.envs.toy_text.blackjack:BlackjackEnv": "blackjack",
    "gymnasium.envs.toy_text.cliffwalking:CliffWalkingEnv": "cliff_walking",
    "gymnasium.envs.toy_text.frozen_lake:FrozenLakeEnv": "frozen_lake",
    "gymnasium.envs.toy_text.taxi:TaxiEnv": "taxi",
    "highway_env.envs.highway_env:HighwayEnv": "highway",
    "minigrid.envs.babyai.core.roomgrid_level:RoomGridLevel": "babyai",
    "minigrid.minigrid_env:MiniGridEnv": "minigrid",
    "worlds.wrapped.coin_collector:CoinCollector": "coin_collector",
}


@dataclass(frozen=True)
class Known:
    """What a module knows of its environment."""

    action_words: Mapping[str, Any] = field(default_factory=dict)
    describe: Callable[[Any], str] | None = None
    """An observation in words."""
    table: Callable[[_Env], tuple[Transitions, State, str]] | None = None
    """All transitions, a function that reads the state of an environment, and the source in words; None: there is none,
    or the environment has one of its own.
    """
    state: State | None = None
    """All that decides what happens but time, to explore an environment without a table."""
    fading: Callable[[_Env], Callable[[int], float]] | None = None
    """By what a reward is multiplied after so many actions; None: by 1."""
    expert: Callable[[_Env], Callable[[Any, Mapping[str, Any]], Any]] | None = None
    """Makes an expert for an environment that was reset: a function of observation and info that returns an action. It
    is copied together with the environment. One that keeps track of the episode has a method `took`, which gets each
    action that is taken, and is asked in every state. None: no expert is known.
    """
    horizon: int = 100
    """Most actions of a roll-out that are worth their time."""
    hides: bool = False
    """Whether the student does not see all of the state."""
    heuristic: Heuristic | None = None
    """For searches: the number of actions that are left to the goal; where an episode has to last, the danger."""
    admissible: bool = False
    """Whether the heuristic never guesses more than are needed."""
    lasts: int | None = None
    """For how many actions ahead a search has to keep the episode going; None: the task is to be solved."""
    success: Callable[..., Any] | None = None
    """Whether a step has solved the task; see `worlds.wrapped.gym_world.GymWorld`."""
    goal: str = ""
    """What to do, as in "get to the goal"; empty: that is not known."""


def known(env: _Env) -> Known | None:
    """What is known of an environment, by its class or a base of it; None if it is nothing."""
    for cls in type(env.unwrapped).__mro__:
        if name := _MODULES.get(f"{cls.__module__}:{cls.__qualname__}"):
            found: Known = import_module(f"{__name__}.{name}").KNOWN
            return found
    return None


def words_of(env: _Env) -> dict[str, int]:
    """Words for actions that an environment names itself: by an enumeration `actions`, or by `get_action_meanings`."""
    bare: Any = env.unwrapped
    named = getattr(bare, "actions", None)
    if isinstance(named, enum.EnumMeta):
        return {each.name.lower().replace("_", " "): int(each.value) for each in named}  # type: ignore[var-annotated]
    meanings = getattr(bare, "get_action_meanings", None)
    return {str(word).lower(): action for action, word in enumerate(meanings())} if callable(meanings) else {}
