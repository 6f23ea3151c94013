"""Throughput of lessons in arrays, beside that of Gymnasium's CartPole in arrays."""

import pickle
import time
from collections.abc import Callable, Iterable
from contextlib import closing
from functools import partial
from typing import Any, NamedTuple

import gymnasium
from gymnasium import spaces
from gymnasium.vector import VectorEnv
from rich.table import Table

from llf_teacher.gym.vector import StudentVectorEnv, TeacherVectorEnv
from llf_teacher.registry import PREFIX
from llf_teacher.tools.benchmark.measuring import Call, Player, spread
from llf_teacher.tools.benchmark.player import rate
from llf_teacher.tools.benchmark.timings import RUNS
from pz_envs.family import all_families

STUDENT = "q_learning(forget=False, trust=1.0, optimism=0.0, epsilon=0.1)"
BELIEVER = "obedient(forget=False)"
"""The student of lifetimes with points as actions; it announces nothing."""
EPISODES = 30
MANY = 16_384
"""Number of rows in the measurement of memory."""
_HORIZONS = 12


class Kind(NamedTuple):
    """A row of the table."""

    name: str
    make: Callable[..., VectorEnv[Any, Any, Any]]
    """Makes the environment from `num_envs` and other options; can be pickled."""
    horizon: int
    """Number of steps that reset each row at least once."""
    horizons: int
    """Number of played horizons."""
    anew: dict[str, Any] | None
    """Options that draw each world anew; None if it always draws anew."""


def throughput(
    progress: Callable[[str], object],
    rows: int = 4096,
    horizons: int = _HORIZONS,
    runs: int = RUNS,
    many: int = MANY,
) -> Table:
    """A table of steps per second of CPU time, in millions, with fresh random actions: medians of runs, and ranges.

    `M/s` includes autoresets at the family's own horizon. `anew` draws each world anew instead of from a pool, and
    `pool s` is the time to make the pool, in seconds; equal options share one. `kB` is what each of `many` rows adds
    to the greatest resident memory of a process, in its first lifetime and without a pool. These two figures come from
    one run.
    """
    names = ("M/s", "anew", "pool s", "kB")
    table = Table("environment", *names, title=f"{rows} rows", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for kind in kinds(horizons):
        progress(kind.name)
        env = kind.make(num_envs=rows)
        env.reset(seed=0)
        begin = time.process_time()
        env.reset()
        made = time.process_time() - begin
        cells = [_median(runs, env, kind.horizon * kind.horizons), "", ""]
        if kind.anew is not None:
            anew = kind.make(num_envs=rows, **kind.anew)
            cells[1:] = _median(runs, anew, kind.horizon), f"{made:.1f}"
        table.add_row(kind.name, *cells, f"{_memory(kind, many):.1f}")
    return table


def kinds(horizons: int = _HORIZONS) -> Iterable[Kind]:
    """CartPole, and both seats of all families that support arrays."""
    cartpole = partial(gymnasium.make_vec, "CartPole-v1", vectorization_mode="vector_entry_point")
    yield Kind("CartPole-v1", cartpole, 30, horizons, None)
    for family in all_families():
        if not family.world_batch:
            continue
        id, turns = PREFIX + family.showcase[0], family.max_turns + 1
        anew = {"pool": 0} if "pool" in family.batch_options() else None
        yield Kind(id, partial(StudentVectorEnv, id), turns, horizons, anew)
        world = family.make_world(**family.environments[family.showcase[0]])
        learns = isinstance(world.action_space, spaces.Discrete)
        student = STUDENT if learns else BELIEVER
        lives = partial(TeacherVectorEnv, id, student=student, episodes=EPISODES, announce=learns, budget=20)
        yield Kind(f"{id}, lifetimes", lives, EPISODES * turns, 1, anew)


def _median(runs: int, env: VectorEnv[Any, Any, Any], steps: int) -> str:
    return spread([rate(env, steps) for _ in range(runs)])


def _memory(kind: Kind, rows: int) -> float:
    """Peak memory in a new process, in kB a row."""
    with closing(Player(call_of(kind, rows))) as fresh:
        return float(fresh.play(())[0])


def call_of(kind: Kind, rows: int, steps: int | None = None) -> Call:
    """The work of a process that measures its rate over a number of steps, or without steps the memory of a row."""
    if steps is not None:
        return Call("rows", (pickle.dumps(kind.make), rows, steps))
    return Call("resident", (pickle.dumps(partial(kind.make, **kind.anew or {})), rows, kind.horizon))
