"""Steps in arrays beside gymnax, JAX's environments: our houses and arms, and its FourRooms, on one core.

In an environment of its own, since gymnax pins Gymnasium; `--before` is the folder of another revision:

    pip install gymnax six && pip install -e . -c constraints.txt
    git worktree add ../before REVISION && taskset -c 0 python examples/beside_gymnax.py --before ../before
"""

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import gymnasium
import numpy as np

import llf_teacher  # noqa: F401  (registers the environments)

try:
    import gymnax
    import jax
except ModuleNotFoundError as error:
    raise SystemExit(f"{error}; install it by: pip install gymnax six") from None

ROWS, ROUNDS = (64, 1024, 4096, 16384), 3
STEPS = 252
IDS = {"gridworld": "llf-gridworld-v0", "bandits": "llf-bandits-BanditTenArmedRandomFixed-v0"}
HERE = Path(__file__).parent.parent


def ours(id: str, rows: int) -> float:
    """Millions of steps a second of the processor, with all that the teacher says as arrays."""
    envs = gymnasium.make_vec(id, num_envs=rows, vectorization_mode="vector_entry_point")
    envs.reset(seed=0)
    envs.reset()  # draws from the pool of houses, which is made now
    actions = np.random.default_rng(0).integers(int(envs.single_action_space.n), size=(STEPS + 1, rows))
    envs.step(actions[0])
    begin = time.process_time()
    for each in actions[1:]:
        envs.step(each)
    return STEPS * rows / (time.process_time() - begin) / 1e6


def four_rooms(rows: int) -> tuple[float, float]:
    """The same of gymnax's FourRooms: a compiled step at a time, and all steps as one compiled loop."""
    env, settings = gymnax.make("FourRooms-misc")
    key = jax.random.PRNGKey(0)
    actions = jax.random.randint(key, (STEPS, rows), 0, 4)
    keys = jax.random.split(key, STEPS * rows).reshape(STEPS, rows, -1)
    step = jax.jit(jax.vmap(env.step, (0, 0, 0, None)))
    _, start = jax.jit(jax.vmap(env.reset, (0, None)))(jax.random.split(key, rows), settings)

    def one_by_one() -> None:
        state = start
        for i in range(STEPS):
            result = step(keys[i], state, actions[i], settings)
            state = result[1]
        jax.block_until_ready(result)

    @jax.jit
    def loop(state):  # noqa: ANN001, ANN202  (JAX's own)
        def turn(state, drawn):  # noqa: ANN001, ANN202
            result = step(drawn[0], state, drawn[1], settings)
            return result[1], (result[0].sum(), result[2].sum())

        return jax.lax.scan(turn, state, (keys, actions))

    rates = []
    for play in (one_by_one, lambda: jax.block_until_ready(loop(start))):
        play()  # compiles
        begin = time.process_time()
        play()
        rates.append(STEPS * rows / (time.process_time() - begin) / 1e6)
    return rates[0], rates[1]


def apart(folder: Path, name: str, rows: int) -> float:
    """`ours` by the code in a folder, in a process of its own."""
    command = [sys.executable, __file__, "--one", name, str(rows)]
    found = subprocess.run(  # noqa: S603  (this file)
        command, env=os.environ | {"PYTHONPATH": str(folder)}, capture_output=True, text=True, check=True
    )
    return float(found.stdout)


def main() -> None:
    """Print a table: medians of some rounds, each of which measures all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--before", type=Path, help="folder of another revision")
    parser.add_argument("--rows", type=int, nargs="+", default=ROWS)
    parser.add_argument("--one", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        name, rows = arguments.one
        print(ours(IDS[name], int(rows)))
        return
    folders = {"before": arguments.before.resolve()} if arguments.before else {}
    folders["now"] = HERE
    columns = [f"{name}, {when}" for name in IDS for when in folders]
    print(f"| rows | {' | '.join(columns)} | FourRooms, step by step | FourRooms, in one loop |")
    print("|---" * (len(columns) + 3) + "|")
    for rows in arguments.rows:
        rounds = [
            [*(apart(folder, name, rows) for name in IDS for folder in folders.values()), *four_rooms(rows)]
            for _ in range(ROUNDS)
        ]
        cells = [f"{rate:.2f}" for rate in np.median(rounds, axis=0)]
        print(f"| {rows} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
