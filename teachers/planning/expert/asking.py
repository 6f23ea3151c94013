"""Experts: their interface, and how to ask them without disturbing the episode."""

import contextlib
import copy
from collections.abc import Callable, Mapping
from typing import Any, Self

import gymnasium

from teachers.planning.planner import PlanningError
from worlds.actions import canonical, native, syntax
from worlds.wrapped.position import still

_Env = gymnasium.Env[Any, Any]
Policy = Callable[[Any, Mapping[str, Any]], Any]
"""Takes an observation and an info and returns an action; its method `took`, if any, gets every action."""


class ExpertError(RuntimeError):
    """An expert gives no usable answer; the message says why."""


class ReplayError(ExpertError):
    """An episode cannot be replayed: something decides that neither its seed nor its actions do."""


def policy_of(given: Any) -> Policy:
    """A policy as a function.

    Args:
        given: a function `(observation, info) -> action`, or a model with `predict(observation, deterministic=True)`.

    Raises:
        ValueError: it is neither.
    """
    if callable(getattr(given, "predict", None)):
        return _Model(given)
    if not callable(given) or isinstance(given, type):
        raise ValueError(
            "policy must be a function (observation, info) -> action, or have predict(observation, deterministic=True) "
            f"as the models of Stable-Baselines3, got {given!r}"
        )
    function: Policy = given
    return function


class _Model:
    """A model of Stable-Baselines3 as a policy."""

    def __init__(self, model: Any) -> None:
        self._model = model

    def __call__(self, observation: Any, info: Mapping[str, Any]) -> Any:
        answer = self._model.predict(observation, deterministic=True)
        return answer[0] if isinstance(answer, tuple) else answer


class Same:
    """Returns the same policy for every environment."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def __call__(self, env: _Env) -> Policy:
        """Return the policy."""
        return self._policy


class Watched:
    """An environment of its own, and the expert that has watched it since its reset.

    Args:
        env: the environment, after its reset.
        policy: the expert.
        observation, info: the results of `reset`.
        bound: whether the policy belongs to this environment; then both are copied together.
    """

    def __init__(self, env: _Env, policy: Policy, observation: Any, info: Mapping[str, Any], bound: bool) -> None:
        self.env, self.policy, self.observation, self.info, self._bound = env, policy, observation, info, bound

    @classmethod
    def begin(cls, env: _Env, make: Callable[[_Env], Policy], observation: Any, info: Mapping[str, Any]) -> Self:
        """The scene after a reset.

        Raises:
            ExpertError: there is no expert for this episode.
        """
        try:
            policy = make(env)
        except PlanningError:
            raise
        except Exception as error:
            raise ExpertError(f"the expert raised {error!r} at the start of the episode") from error
        return cls(env, policy, observation, info, not isinstance(make, Same))

    def copy(self) -> Self:
        """A copy that continues like this one."""
        env, policy = copy.deepcopy((self.env, self.policy)) if self._bound else (copy.deepcopy(self.env), self.policy)
        return type(self)(env, policy, still(self.observation), self.info, self._bound)

    def ask(self) -> Any:
        """The expert's action now, in canonical form.

        Raises:
            ExpertError: the expert raises, or returns no legal action.
        """
        try:
            given = self.policy(still(self.observation), self.info)
        except Exception as error:
            raise ExpertError(f"the expert raised {error!r}") from error
        space = self.env.action_space
        try:
            return canonical(space, given)
        except (ValueError, TypeError, OverflowError):
            got = repr(given)
            got = got if len(got) <= 80 else f"{got[:77]}..."
            raise ExpertError(f"the expert gave {got}, which is no action; allowed: {syntax(space)}") from None

    def step(self, action: Any) -> tuple[float, bool]:
        """Take an action in canonical form; return the reward, and whether the episode is over.

        Raises:
            ExpertError: the environment raises, or its reward is no number.
        """
        took = getattr(self.policy, "took", None)
        if took is not None:
            with contextlib.suppress(ExpertError):  # it is asked in every state, as in play of its own
                self.ask()
        space = self.env.action_space
        try:
            self.observation, paid, terminated, truncated, self.info = self.env.step(native(space, action))
            reward, over = float(paid), bool(terminated or truncated)
        except Exception as error:
            raise ExpertError(f"the environment raised {error!r} after action {action} when it was tried") from error
        if took is not None:
            took(action)
        return reward, over
