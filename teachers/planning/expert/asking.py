"""Experts: what counts as one, and how it is asked without disturbing what is played."""

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
"""Takes an observation and an info, and gives an action; one with a method `took` is told each action that is taken."""


class ExpertError(RuntimeError):
    """Raised where an expert gives no answer that can be passed on; it says why."""


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
    """Gives one policy for every environment."""

    def __init__(self, policy: Policy) -> None:
        self._policy = policy

    def __call__(self, env: _Env) -> Policy:
        """The policy."""
        return self._policy


class Watched:
    """An environment of its own, and the expert that watches it from its reset on.

    Args:
        env: the environment, which was reset.
        policy: the expert.
        observation, info: what `reset` gave.
        bound: whether the policy belongs to this environment, so that both are copied together.
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
        """Another one, which goes on like this one."""
        env, policy = copy.deepcopy((self.env, self.policy)) if self._bound else (copy.deepcopy(self.env), self.policy)
        return type(self)(env, policy, still(self.observation), self.info, self._bound)

    def ask(self) -> Any:
        """What the expert would do now, in canonical form.

        Raises:
            ExpertError: the expert raises, or gives what is no action.
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
        """Take an action in canonical form: the reward, and whether the episode is over.

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
