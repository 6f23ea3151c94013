"""A trial of an expert and its environment, before the first lesson."""

import copy
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import gymnasium
import numpy as np

from teachers.planning.expert.asking import ExpertError, Policy, Watched
from teachers.planning.planner import PlanningError, UnfitError, shared_draws
from worlds.actions import canonical
from worlds.wrapped.generators import reseed
from worlds.wrapped.layers import is_plain, layers
from worlds.wrapped.position import same, still

_Env = gymnasium.Env[Any, Any]
_EPISODES = 100  # at most
_STEPS = 20  # of an episode, at most
_TOTAL = 300  # steps of all episodes; counted, not timed, so that every machine finds the same


class _Seen(NamedTuple):
    """What happened in a step of a trial."""

    asked: Any
    """The expert's answer; None if it gave none."""
    before: Any
    """The observation before the step."""
    after: Any


def try_out(env: _Env, make: Callable[[_Env], Policy]) -> bool:
    """Play some steps, half of them by the expert; return whether other random draws changed anything.

    Raises:
        PlanningError: the expert gives no answer, or two in one state; or a replay of the environment differs.
    """
    shared = shared_draws()
    first, again = list(_play(env, make, 0, 0)), list(_play(env, make, 0, 0))
    for mine, its in zip(first, again, strict=False):  # the second one may end earlier
        if not same(mine.before, its.before):
            raise _unlike(env)
        if not same(mine.asked, its.asked):
            raise PlanningError(
                f"the expert changes its mind: asked twice in one state it gave {mine.asked!r} and {its.asked!r}; "
                "make it deterministic, such as by the most probable action"
            )
        if not same(mine.after, its.after):
            raise _unlike(env)
    if not same(shared_draws(), shared):
        raise PlanningError(
            "the environment or the expert draws from the generators that all of Python or NumPy share, which roll-outs"
            " would change for the lesson; let the environment draw from its np_random"
        )
    steps = 0
    for seed in range(_EPISODES):
        one, other = (list(_play(env, make, seed, draws)) for draws in (0, 1))
        if any(not same(mine.after, its.after) for mine, its in zip(one, other, strict=False)):
            return False
        steps += len(one)
        if steps > _TOTAL:
            break
    return True


def _unlike(env: _Env) -> UnfitError:
    around = [type(layer).__name__ for layer in layers(env) if not is_plain(layer)]
    keeps = f"it, or {' or '.join(around)} around it," if around else "it"
    return UnfitError(
        "the same seed and actions had two results: the environment draws from a random generator that "
        f"reset(seed=...) does not seed, or that is none of its attributes; or {keeps} keeps something from one "
        "episode to the next"
    )


def _play(env: _Env, make: Callable[[_Env], Policy], seed: int, draws: int) -> Iterator[_Seen]:
    """Play an episode; `draws` seeds the random draws after the reset."""
    observation, info = env.reset(seed=seed)
    try:
        scene = Watched.begin(env, make, observation, info)
    except ExpertError as error:
        raise PlanningError(f"{error} (after reset(seed={seed}))") from error
    reseed(env, seed, draws)
    space, rng = copy.deepcopy(env.action_space), np.random.default_rng(seed)
    space.seed(seed)
    for step in range(_STEPS):
        try:
            asked = scene.ask()
        except ExpertError as error:
            if not step:
                raise PlanningError(f"{error} (after reset(seed={seed}))") from error
            asked = None
        before, sample = still(scene.observation), canonical(space, space.sample())
        try:
            reward, over = scene.step(sample if asked is None or rng.random() < 0.5 else asked)
        except ExpertError as error:
            raise PlanningError(f"{error} (step {step + 1} after reset(seed={seed}))") from error
        yield _Seen(asked, before, (still(scene.observation), reward, over))
        if over:
            return
