"""Knowledge about single environments: words, transition rules, and experts.

Each has a module with its knowledge in `KNOWN`.
"""

import enum
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from types import FunctionType
from typing import Any

import gymnasium
from gymnasium import spaces

from teachers.planning.transitions import Transitions
from worlds.wrapped.layers import is_plain, layers

_Env = gymnasium.Env[Any, Any]
State = Callable[[_Env], Hashable]
"""Reads the key of an environment's current state."""

_MODULES = {
    "gymnasium.envs.box2d.lunar_lander:LunarLander": "lunar_lander",
    "gymnasium.envs.toy_text.blackjack:BlackjackEnv": "blackjack",
    "gymnasium.envs.toy_text.cliffwalking:CliffWalkingEnv": "cliff_walking",
    "gymnasium.envs.toy_text.frozen_lake:FrozenLakeEnv": "frozen_lake",
    "gymnasium.envs.toy_text.taxi:TaxiEnv": "taxi",
    "minigrid.envs.babyai.core.roomgrid_level:RoomGridLevel": "babyai",
    "minigrid.minigrid_env:MiniGridEnv": "minigrid",
}
_HARMLESS = frozenset({"close", "metadata", "render"})  # what subclasses may override without another rule


@dataclass(frozen=True)
class Known:
    """What a module knows about its environment."""

    action_words: Mapping[str, Any] = field(default_factory=dict)
    describe: Callable[[Any], str] | None = None
    """An observation in words."""
    table: Callable[[_Env], tuple[Transitions, State, str]] | None = None
    """Returns all transitions, a reader of the state, and the source in words; None without rules."""
    state: State | None = None
    """Reads all that determines the future except time, to explore an environment without a table."""
    fading: Callable[[_Env], Callable[[int], float]] | None = None
    """Makes the factor of a reward by the number of earlier actions; None: rewards do not fade."""
    expert: Callable[[_Env], Callable[[Any, Mapping[str, Any]], Any]] | None = None
    """Makes an expert for an environment after its reset: a function of observation and info that returns an action.
    It is copied together with the environment. An expert that tracks the episode has a method `took`; this gets every
    action, and the expert is asked in every state. None: no expert is known.
    """
    horizon: int = 100
    """Most actions of a roll-out."""
    hides: bool | None = False
    """Whether the state has parts that the student does not see; None: unknown."""
    free: frozenset[str] = frozenset()
    """Attributes that subclasses may override without changing the rules, such as a method that draws a start."""
    lacks: Callable[[_Env], str] | None = None
    """Says what the environment's own table lacks with its options, in words; empty if the table is complete."""
    options: Callable[[_Env], Hashable] | None = None
    """Reads the options that a table depends on and that may change after it was made; None: there are none."""
    success: Callable[..., Any] | None = None
    """Whether a step has solved the task; see `worlds.wrapped.gym_world.GymWorld`."""
    unlike: str = ""
    """Why the rules of a base class of the environment do not apply; empty if they do."""


def known(env: _Env) -> Known | None:
    """The knowledge about an environment, by its class or a base class; None if there is none.

    Rules are left out for a subclass from another package that overrides them, for an environment with patched methods,
    and behind a wrapper that may change them. Behind a wrapper that may change actions or observations, experts and
    words for observations are left out.
    """
    for cls in type(env.unwrapped).__mro__:
        if name := _MODULES.get(f"{cls.__module__}:{cls.__qualname__}"):
            found: Known = import_module(f"{__name__}.{name}").KNOWN
            if not all(map(is_plain, layers(env))):
                found = _without_rules(found)
            if other := _other_rules(env.unwrapped, cls, _HARMLESS | found.free):
                found = replace(_without_rules(found), success=None, unlike=other)
            if any(isinstance(each, gymnasium.ObservationWrapper) or not _acts(each) for each in layers(env)):
                found = replace(found, hides=found.hides or None, describe=None, expert=None)
            return found
    return None


def _without_rules(found: Known) -> Known:
    return replace(found, table=None, state=None, fading=None, hides=found.hides or None)


def _other_rules(bare: _Env, base: type, free: frozenset[str]) -> str:
    """Why the rules of a base class may not hold: overrides in another package, or patches; empty if they hold."""
    mine = type(bare).__mro__
    elsewhere = [cls for cls in mine[: mine.index(base)] if _home(cls) != _home(base)]
    names = {name for cls in elsewhere for name in vars(cls) if hasattr(base, name) and name[:2] != "__"} - free
    what = ", ".join(sorted(names)) or is_patched(bare) * "a method in place"
    return what and f"{type(bare).__name__} overrides {what}, so that rules known of {base.__name__} may not hold"


def is_patched(layer: Any) -> bool:
    """Whether an environment or a wrapper has a method from outside its class's own package."""
    cls = type(layer)
    if any(callable(each) and callable(getattr(cls, name, None)) for name, each in vars(layer).items()):
        return True
    functions = ((base, each) for base in cls.__mro__ for name, each in vars(base).items() if name[:2] != "__")
    return any(_home(base) != _home(function) for base, each in functions if (function := _function(each)) is not None)


def _function(member: Any) -> FunctionType | None:
    """The function of a method or a property; None if it is neither."""
    found = getattr(member, "__func__", None) or getattr(member, "fget", None) or member
    return found if isinstance(found, FunctionType) else None


def _home(value: type | FunctionType) -> str:
    """The package of a class or a function."""
    return value.__module__.partition(".")[0]


def words_of(env: _Env, own: Known) -> Mapping[str, int]:
    """Words for actions: from `own`, an enumeration `actions`, or `get_action_meanings`.

    Empty if they do not name all actions, or if a wrapper may change actions.
    """
    bare, space = env.unwrapped, env.action_space
    named, meanings = getattr(bare, "actions", None), getattr(bare, "get_action_meanings", None)
    words: Mapping[str, Any] = own.action_words
    if not words and isinstance(named, enum.EnumMeta):
        words = {each.name.lower().replace("_", " "): each.value for each in named}  # type: ignore[var-annotated]
    elif not words and callable(meanings):
        words = {str(word).lower(): action for action, word in enumerate(meanings())}
    fits = isinstance(space, spaces.Discrete) and set(words.values()) == set(range(int(space.n))) and space.start == 0
    return words if fits and all(map(_acts, layers(env))) else {}


def _acts(layer: Any) -> bool:
    """Whether a layer passes on actions unchanged."""
    pays = isinstance(layer, gymnasium.RewardWrapper) and type(layer).step is gymnasium.RewardWrapper.step
    return pays or is_plain(layer)
