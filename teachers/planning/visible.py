"""Whether the student's observations determine the next ones, tested by random play."""

import copy
from collections.abc import Hashable
from typing import Any

import gymnasium

from teachers.planning.known import Known
from teachers.planning.planner import stepped
from teachers.planning.state_key import comparable
from worlds.wrapped.generators import shake

_Env = gymnasium.Env[Any, Any]
_EPISODES, _STEPS = 500, 20  # of random play, and steps of each
_TOTAL = 5_000  # steps of all episodes; counted, not timed, so that every machine finds the same
_PATIENCE = 30  # episodes in which an observation has to come again


def privileged(env: _Env, own: Known | None) -> bool | None:
    """Whether a teacher who plans from states of an environment knows more than the student sees.

    Args:
        env: the environment, which is reset and stepped.
        own: the module's knowledge of it, if any.

    Returns:
        The answer in `own` if it has one; else True if play shows hidden state, and None if not.
    """
    if own is not None and own.hides is not None:
        return own.hides
    return _hides(env) or None


def _hides(env: _Env) -> bool:
    """Whether play finds one action with two results after equal observations, turns and draws."""
    space = copy.deepcopy(env.action_space)
    space.seed(0)
    seen: dict[Hashable, Hashable] = {}
    again = steps = 0
    for seed in range(_EPISODES):
        observation, _ = env.reset(seed=seed)
        for turn in range(_STEPS):
            action = space.sample()
            shake(env, 0)
            before = observation
            observation, reward, terminated, truncated, _ = stepped(env, action)
            try:
                key = turn, comparable(before), comparable(action)
                result = comparable(observation), repr(float(reward)), terminated
            except TypeError:  # an observation of a kind that cannot be compared
                return False
            again += key in seen
            steps += 1
            if seen.setdefault(key, result) != result:
                return True
            if terminated or truncated:
                break
        if steps >= _TOTAL or (seed > _PATIENCE and not again):
            break
    return False
