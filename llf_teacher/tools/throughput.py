"""Throughput: lessons in arrays, in a second of the processor, beside Gymnasium's own CartPole in arrays."""

import time
import tracemalloc
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import VectorEnv
from rich.table import Table

from llf_teacher.gym.vector import StudentVectorEnv, TeacherVectorEnv
from llf_teacher.registry import PREFIX
from pz_envs.family import all_families

STUDENT = "q_learning(forget=False, trust=1.0, optimism=0.0, epsilon=0.1)"
EPISODES = 30
_HORIZONS = 12
_ENDLESS = 1_000_000
_ROUND = 50  # steps whose actions are kept at once


class Kind(NamedTuple):
    """What is measured in a row of the table."""

    name: str
    make: Callable[..., VectorEnv[Any, Any, Any]]
    """Makes it of a number of rows, and other options."""
    horizon: int
    """Steps after which each row has begun again, at the latest."""
    horizons: int
    """How many of them are played."""
    anew: dict[str, Any] | None
    """Options with which each world is drawn anew, if that is not always so."""
    endless: dict[str, Any]
    """Options with which no episode ends."""


def throughput(rows: int = 4096, horizons: int = _HORIZONS, progress: Callable[[str], Any] | None = None) -> Table:
    """Steps per second of the processor in one run, in millions, with fresh random actions.

    Autoresets at the family's own horizon are included, `steps alone` has none, and `resets alone` has nothing else.
    `anew` draws each world anew where others come from a pool; `pool s` is what that takes to be made, once. `kB` is
    the memory of a row, its share of the pool included.
    """
    names = ("M/s", "steps alone", "resets alone", "anew", "pool s", "kB")
    table = Table("environment", *names, title=f"{rows} rows", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for kind in _kinds(horizons):
        if progress:
            progress(kind.name)
        env = kind.make(rows)
        env.reset(seed=0)
        begin = time.process_time()
        env.reset()
        made = time.process_time() - begin
        steps = kind.horizon * kind.horizons
        cells = [_rate(env, steps), _rate(kind.make(rows, **kind.endless), steps), _resets(env)]
        cells.append("" if kind.anew is None else _rate(kind.make(rows, **kind.anew), kind.horizon))
        cells.append("" if kind.anew is None else f"{made:.1f}")
        table.add_row(kind.name, *cells, f"{_memory(kind, rows):.1f}")
    return table


def _kinds(horizons: int) -> Iterable[Kind]:
    """CartPole, and both seats of all families that can be played in arrays."""
    yield Kind("CartPole-v1", _cartpole, 30, horizons, None, {})
    for family in all_families():
        if not family.world_batch:
            continue
        id, turns = PREFIX + family.showcase[0], family.max_turns + 1
        anew = {"pool": 0} if "pool" in family.batch_options() else None
        yield Kind(id, _student(id), turns, horizons, anew, {"max_turns": _ENDLESS})
        world = family.make_world(**family.environments[family.showcase[0]])
        if isinstance(world.action_space, spaces.Discrete):
            yield Kind(f"{id}, lifetimes", _teacher(id), EPISODES * turns, 1, anew, {"episodes": _ENDLESS})


def _cartpole(rows: int) -> VectorEnv[Any, Any, Any]:
    return gymnasium.make_vec("CartPole-v1", num_envs=rows, vectorization_mode="vector_entry_point")


def _student(id: str) -> Callable[..., VectorEnv[Any, Any, Any]]:
    return lambda rows, **options: StudentVectorEnv(id, rows, **options)


def _teacher(id: str) -> Callable[..., VectorEnv[Any, Any, Any]]:
    settings = {"student": STUDENT, "episodes": EPISODES, "announce": True, "budget": 20}
    return lambda rows, **options: TeacherVectorEnv(id, rows, **{**settings, **options})


def _rate(env: VectorEnv[Any, Any, Any], steps: int) -> str:
    """Steps of all rows in a second, in millions; actions are drawn before."""
    env.reset(seed=0)
    env.reset()
    env.step(next(_fresh(env)))
    fresh = _fresh(env)
    spent, done = 0.0, 0
    while done < steps:
        actions = list(islice(fresh, min(_ROUND, steps - done)))  # none is played twice
        begin = time.process_time()
        for each in actions:
            env.step(each)
        spent += time.process_time() - begin
        done += len(actions)
    return f"{done * env.num_envs / spent / 1e6:.2f}"


def _fresh(env: VectorEnv[Any, Any, Any]) -> "Iterator[np.ndarray[Any, Any]]":
    """Random actions for all rows, again and again."""
    rng, space = np.random.default_rng(0), env.single_action_space
    while True:
        if isinstance(space, spaces.Discrete):
            yield rng.integers(int(space.n), size=env.num_envs)
        else:
            low, high = space.low, space.high  # type: ignore[attr-defined]  # the others are boxes
            yield rng.uniform(low, high, (env.num_envs, *(space.shape or ())))


def _resets(env: VectorEnv[Any, Any, Any]) -> str:
    """Resets of all rows in a second, in millions."""
    begin = time.process_time()
    for _ in range(_HORIZONS):
        env.reset()
    return f"{_HORIZONS * env.num_envs / (time.process_time() - begin) / 1e6:.2f}"


def _memory(kind: Kind, rows: int) -> float:
    """Thousands of bytes a row that an environment holds once it is in use."""
    tracemalloc.start()
    try:
        env = kind.make(rows)
        env.reset(seed=0)
        env.reset()
        env.step(next(_fresh(env)))
        held, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    return held / rows / 1000
