"""Steps in arrays by number of rows, beside gymnax, JAX's environments: its FourRooms, which says nothing, on one core.

In an environment of its own, since gymnax pins Gymnasium; of a folder with an earlier revision its rows, too:

    pip install gymnax six && pip install -e . -c constraints.txt
    git worktree add ../before d1848cec && taskset -c 0 python examples/beside_gymnax.py ../before
"""

import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, closing, suppress
from functools import partial
from itertools import product
from pathlib import Path

from llf_teacher.tools.benchmark.measuring import Player, spread
from llf_teacher.tools.throughput import MANY, call_of, kinds

try:
    import gymnax
    import jax
except ModuleNotFoundError as error:
    raise SystemExit(f"{error}; install it by: pip install gymnax six") from None

ROWS, STEPS, ROUNDS = (1, 256, 4096, 16_384), 2**20, 5
"""Numbers of rows, steps of all rows together, and times that each is timed."""


def four_rooms(rows: int, steps: int) -> tuple[Callable[[], float], Callable[[], float]]:
    """Time gymnax's FourRooms: a compiled step at a time, and all steps as one compiled loop."""
    env, settings = gymnax.make("FourRooms-misc")
    key = jax.random.PRNGKey(0)
    actions = jax.random.randint(key, (steps, rows), 0, 4)
    keys = jax.random.split(key, steps * rows).reshape(steps, rows, -1)
    step = jax.jit(jax.vmap(env.step, (0, 0, 0, None)))
    _, start = jax.jit(jax.vmap(env.reset, (0, None)))(jax.random.split(key, rows), settings)

    def one_by_one() -> None:
        state = start
        for i in range(steps):
            result = step(keys[i], state, actions[i], settings)
            state = result[1]
        jax.block_until_ready(result)

    @jax.jit
    def loop(state):  # noqa: ANN001, ANN202  (JAX's own)
        def turn(state, drawn):  # noqa: ANN001, ANN202
            result = step(drawn[0], state, drawn[1], settings)
            return result[1], (result[0].sum(), result[2].sum())

        return jax.lax.scan(turn, state, (keys, actions))

    def timed(play: Callable[[], object]) -> Callable[[], float]:
        def once() -> float:
            begin = time.process_time()
            play()
            return steps * rows / (time.process_time() - begin) / 1e6

        play()  # compiles
        return once

    return timed(one_by_one), timed(lambda: jax.block_until_ready(loop(start)))


TREES = dict(zip(("", ", before"), (None, *map(Path, sys.argv[1:])), strict=False))
"""By what is added to a row's name, the folder of our packages; None: those of this process."""


def answer(player: Player) -> float | None:
    """A process's answer; None if its packages lack what is asked of it, which it says itself."""
    with suppress(RuntimeError):
        return float(player.play(())[0])
    return None


table: dict[str, list[str]] = {}
for rows in ROWS:
    steps = min(2000, STEPS // rows)
    with ExitStack() as stack:
        timers: dict[str, Callable[[], float | None]] = {}
        for kind, (name, tree) in product(kinds(), TREES.items()):
            player = stack.enter_context(closing(Player(call_of(kind, rows, steps), tree)))
            timers[kind.name + name] = partial(answer, player)
        timers["FourRooms, step by step"], timers["FourRooms, all steps in one loop"] = four_rooms(rows, steps)
        rounds = [{name: once() for name, once in timers.items()} for _ in range(ROUNDS)]
    for name in timers:
        found = [rate for each in rounds if (rate := each[name]) is not None]
        table.setdefault(name, []).append(spread(found, "{:.3g}".format) if found else "")
for kind, (name, tree) in product(kinds(), TREES.items()):
    with closing(Player(call_of(kind, MANY), tree)) as player:
        table[kind.name + name].append("" if (found := answer(player)) is None else f"{found:.1f}")
heads = [f"{rows:,}" for rows in ROWS] + ["kB a row"]
print(f"| M steps a second, by rows | {' | '.join(heads)} |\n|---{'|---' * len(heads)}|")
for name, cells in table.items():
    print(f"| {name} | {' | '.join([*cells, ''][: len(heads)])} |")
