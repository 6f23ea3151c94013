"""Throughput of lessons in arrays, beside that of Gymnasium's CartPole in arrays."""

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
from llf_teacher.tools.benchmark.measuring import spread
from llf_teacher.tools.benchmark.timings import RUNS
from pz_envs.family import all_families

STUDENT = "q_learning(forget=False, trust=1.0, optimism=0.0, epsilon=0.1)"
EPISODES = 30
_HORIZONS = 12
_ENDLESS = 1_000_000
_ROUND = 50  # steps whose actions are drawn at once


class Kind(NamedTuple):
    """A row of the table."""

    name: str
    make: Callable[..., VectorEnv[Any, Any, Any]]
    """Makes the environment from the number of its rows and other options."""
    horizon: int
    """Number of steps in which each row is reset at least once."""
    horizons: int
    """Number of horizons that are played."""
    anew: dict[str, Any] | None
    """Options that draw each world anew; None if that is always done."""
    endless: dict[str, Any]
    """Options under which no episode ends."""


def throughput(
    progress: Callable[[str], object], rows: int = 4096, horizons: int = _HORIZONS, runs: int = RUNS
) -> Table:
    """A table of steps per second of CPU time, in millions, with fresh random actions: medians of runs, and ranges.

    `M/s` includes autoresets at the family's own horizon, `steps alone` has no resets, `resets alone` has no steps.
    `anew` draws each world anew instead of from a pool, and `pool s` is the time to make the pool, in seconds. `kB` is
    the memory of a row, with its share of the pool; these two are of one run.
    """
    names = ("M/s", "steps alone", "resets alone", "anew", "pool s", "kB")
    table = Table("environment", *names, title=f"{rows} rows", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for kind in _kinds(horizons):
        progress(kind.name)
        env = kind.make(rows)
        env.reset(seed=0)
        begin = time.process_time()
        env.reset()
        made = time.process_time() - begin
        steps = kind.horizon * kind.horizons
        endless = kind.make(rows, **kind.endless)
        cells = [_median(runs, _rate, env, steps), _median(runs, _rate, endless, steps), _median(runs, _resets, env)]
        anew = None if kind.anew is None else kind.make(rows, **kind.anew)
        cells.append("" if anew is None else _median(runs, _rate, anew, kind.horizon))
        cells.append("" if kind.anew is None else f"{made:.1f}")
        table.add_row(kind.name, *cells, f"{_memory(kind, rows):.1f}")
    return table


def _kinds(horizons: int) -> Iterable[Kind]:
    """CartPole, and both seats of all families that support arrays."""
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


def _median(runs: int, figure: Callable[..., float], *arguments: Any) -> str:
    return spread([figure(*arguments) for _ in range(runs)])


def _rate(env: VectorEnv[Any, Any, Any], steps: int) -> float:
    """Steps of all rows per second, in millions; drawing the actions is not timed."""
    env.reset(seed=0)
    env.reset()
    env.step(next(_fresh(env)))
    fresh = _fresh(env)
    spent, done = 0.0, 0
    while done < steps:
        actions = list(islice(fresh, min(_ROUND, steps - done)))  # no action is played twice
        begin = time.process_time()
        for each in actions:
            env.step(each)
        spent += time.process_time() - begin
        done += len(actions)
    return done * env.num_envs / spent / 1e6


def _fresh(env: VectorEnv[Any, Any, Any]) -> "Iterator[np.ndarray[Any, Any]]":
    """Random actions for all rows, without end."""
    rng, space = np.random.default_rng(0), env.single_action_space
    while True:
        if isinstance(space, spaces.Discrete):
            yield rng.integers(int(space.n), size=env.num_envs)
        else:
            low, high = space.low, space.high  # type: ignore[attr-defined]  # the others are boxes
            yield rng.uniform(low, high, (env.num_envs, *(space.shape or ())))


def _resets(env: VectorEnv[Any, Any, Any]) -> float:
    """Resets of all rows per second, in millions."""
    begin = time.process_time()
    for _ in range(_HORIZONS):
        env.reset()
    return _HORIZONS * env.num_envs / (time.process_time() - begin) / 1e6


def _memory(kind: Kind, rows: int) -> float:
    """Memory of an environment in use, in thousands of bytes per row."""
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
