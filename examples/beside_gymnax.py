"""Steps in arrays by number of rows, beside gymnax, JAX's environments: its FourRooms, which says nothing, on one core.

In an environment of its own, since gymnax pins Gymnasium:

    pip install gymnax six && pip install -e . -c constraints.txt && taskset -c 0 python examples/beside_gymnax.py
"""

import time
from collections.abc import Callable
from functools import partial
from statistics import median

from llf_teacher.tools.throughput import kinds, rate

try:
    import gymnax
    import jax
except ModuleNotFoundError as error:
    raise SystemExit(f"{error}; install it by: pip install gymnax six") from None

ROWS, STEPS, ROUNDS = (1, 256, 4096, 16_384), 2**20, 3
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


table: dict[str, list[str]] = {}
for rows in ROWS:
    steps = min(2000, STEPS // rows)
    timers = {kind.name: partial(rate, kind.make(num_envs=rows), steps) for kind in kinds()}
    timers["FourRooms, step by step"], timers["FourRooms, all steps in one loop"] = four_rooms(rows, steps)
    rounds = [{name: once() for name, once in timers.items()} for _ in range(ROUNDS)]
    for name in timers:
        found = median(each[name] for each in rounds)
        table.setdefault(name, []).append(f"{found:.2f}" if found >= 0.1 else f"{found:.2g}")
print(f"| M steps a second, by rows | {' | '.join(f'{rows:,}' for rows in ROWS)} |\n|---{'|---' * len(ROWS)}|")
for name, cells in table.items():
    print(f"| {name} | {' | '.join(cells)} |")
