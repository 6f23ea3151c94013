"""The interface of planners, and their result."""

import copy
import random
import reprlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, SupportsFloat, TypeVar

import gymnasium
import numpy as np

from teachers.oracle import Oracle
from teachers.phrasebook import Phrases
from worlds.wrapped.position import same, still
from worlds.wrapped.shared import SharedState, lacking

_Env = gymnasium.Env[Any, Any]
_T = TypeVar("_T")
_TRIAL = 20  # steps
_RESET, _STEP = 2, 5  # values that Gymnasium demands


_HOLD = "a teacher that plans would change its student's world; hold all state in attributes that are copied"

REWARDS = "rewards"
"""The tier of a teacher that states rewards only."""


class PlanningError(ValueError):
    """A planner cannot serve an environment; the message says why, and what would help."""


class UnfitError(PlanningError):
    """The environment itself forbids planning, by whatever tier: its copies share state, or it does not repeat."""


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

    def plan(
        self, env: _Env, turns: int, success: Callable[..., Any] | None = None, other: _Env | None = None
    ) -> Planned:
        """Plan for an environment, unless its copies would share state with it.

        Args:
            env: an environment, which is reset and stepped; never the student's own.
            turns: most actions of an episode.
            success: whether a step has solved the task; None: the environment or the planner decides.
            other: the student's environment, or another one from the same function, which stays as it is.

        Raises:
            PlanningError: it cannot serve the environment.
        """
        return guarded(env, lambda: self._plan(env, turns, success), other)

    @abstractmethod
    def _plan(self, env: _Env, turns: int, success: Callable[..., Any] | None) -> Planned:
        """Plan for an environment; arguments and errors as of `plan`."""


def guarded(env: _Env, do: Callable[[], _T], other: _Env | None = None) -> _T:
    """Do something that steps an environment, and set back what that changes outside of its attributes.

    Args:
        env: the environment.
        do: what steps it.
        other: another environment, which must not notice.

    Raises:
        UnfitError: the environment shares state with its copies, or with `other`, and steps change it.
        PlanningError: the environment raised something.
    """
    others = [] if other is None else [other]
    if (copied := _copied(env)) is not None:
        others.append(copied)
    shared = SharedState(env, others)
    if shared.refusal:
        raise UnfitError(f"{shared.refusal}; {_HOLD}")
    try:
        _try_copy(env)
        result = do()
    except (ValueError, TypeError, Warning) as error:
        if not (changed := _set_back(shared)) or isinstance(error, UnfitError):
            raise
    except Exception as error:
        _set_back(shared)
        raise PlanningError(f"the environment raised {error!r} while it was tried") from error
    else:
        if not (changed := _set_back(shared)):
            return result
    raise UnfitError(f"a step changes {changed}, which copies of the environment share; {_HOLD}")


def _copied(env: _Env) -> _Env | None:
    """A copy of an environment; None if there is none that has all its attributes, so that episodes are replayed."""
    try:
        copied = copy.deepcopy(env)
    except Exception:  # environments may raise anything
        return None
    return None if lacking(env, copied) else copied


def _try_copy(env: _Env) -> None:
    """Step a copy of the environment between its own steps, and look at what both share.

    Raises:
        UnfitError: the copy changes what the original does, or something that both hold.
    """
    before = shared_draws()
    try:
        alone, again = _played(env), _played(env)
        env.reset(seed=0)
    except Exception:  # `check_steps` says what is wrong with it
        return
    if not same(before, shared_draws()):
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002 (set back)
        raise UnfitError(
            "the environment draws from the generators that all of Python or NumPy share, so that copies of it "
            "change what others draw; let it draw from its np_random"
        )
    if (other := _copied(env)) is None:
        return
    shared = SharedState(env, [other])
    try:
        beside = _played(env, other)
    except Exception:  # a copy may lack something
        beside = alone
    if shared.refusal:
        raise UnfitError(f"{shared.refusal}; {_HOLD}")
    if changed := shared.changed():
        raise UnfitError(f"a step changes {changed}, which copies of the environment share; {_HOLD}")
    if same(alone, again) and not same(alone, beside):
        raise UnfitError(f"steps of a copy of the environment change what the original does; {_HOLD}")


def _played(env: _Env, other: _Env | None = None) -> list[Any]:
    """What random play gives, while another environment is reset and takes other actions between the steps."""
    trace = [still(env.reset(seed=0)[0])]
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    actions = [space.sample() for _ in range(_TRIAL)]
    for action, stray in zip(actions, reversed(actions), strict=True):
        if other is not None:
            _, _, terminated, truncated, _ = other.step(stray)
            if terminated or truncated:
                other.reset(seed=1)
        observation, reward, terminated, truncated, _ = env.step(action)
        trace.append((still(observation), float(reward), bool(terminated)))
        if terminated or truncated:
            trace.append(still(env.reset(seed=0)[0]))
    return trace


def _set_back(shared: SharedState) -> str:
    """Set back what has changed, and name it; empty if nothing has."""
    changed = shared.changed()
    shared.restore()
    return changed


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


def unlike(env: _Env, why: str = "") -> PlanningError:
    """The error for an environment whose copies do not continue like the original; resets may show why."""
    begun = f"{why}; and " if why else ""
    try:
        lack = lacking(env, copy.deepcopy(env))
    except Exception as error:
        return PlanningError(f"{begun}it cannot be copied: {error!r}")
    if lack:
        return PlanningError(f"{begun}its copies lack the attribute {lack!r}; let __deepcopy__ copy all attributes")
    first = still(env.reset(seed=0)[0])
    if any(not same(first, still(env.reset(seed=0)[0])) for _ in range(_TRIAL)):
        return UnfitError(f"{begun}reset(seed=0) does not give the same each time; let the seed decide all it draws")
    return PlanningError(f"{begun}its copies do not continue like the original")


def shared_draws() -> Any:
    """The states of the global generators of `random` and NumPy."""
    return random.getstate(), np.random.get_state()  # noqa: NPY002 (only looked at)


def wrong_form(env: _Env) -> str:
    """How the results of an environment's own methods differ from the form that is wanted; empty if they do not."""
    own = env.unwrapped
    where = f"{type(own).__module__}:{type(own).__qualname__}"
    try:
        made = own.reset(seed=0)
        if not isinstance(made, tuple) or len(made) != _RESET:
            return f"{where}.reset must return two values (observation, info), got {reprlib.repr(made)}"
        stepped = own.step(copy.deepcopy(env.action_space).sample())
    except Exception as error:
        takes = " must take the argument `seed`, as in reset(self, *, seed=None, options=None):"
        return f"{where}.reset{takes} {error!r}" if "seed" in f"{error}" and isinstance(error, TypeError) else ""
    if not isinstance(stepped, tuple) or len(stepped) != _STEP:
        number = f"{len(stepped)} values" if isinstance(stepped, tuple) else f"a {type(stepped).__name__}"
        return (
            f"{where}.step must return five values (observation, reward, terminated, truncated, info), got {number}: "
            f"{reprlib.repr(stepped)}"
        )
    return ""


def check_steps(env: _Env) -> None:
    """Check that the environment can be reset and stepped.

    Raises:
        PlanningError: it raised, or its result is not what Gymnasium demands.
    """
    try:
        space = copy.deepcopy(env.action_space)
        space.seed(0)
        _, _ = env.reset(seed=0)
        _, reward, terminated, _, _ = env.step(space.sample())
        if not _is_number(reward):
            raise TypeError(f"the reward must be a number, got {reward!r}")
        bool(terminated)
    except Exception as error:
        raise PlanningError(
            f"the environment cannot be reset and stepped as Gymnasium demands: {wrong_form(env) or repr(error)}; try "
            "gymnasium.utils.env_checker.check_env(env)"
        ) from error
