"""Steps in arrays beside gymnax, JAX's environments: our houses and arms, and its FourRooms, on one core.

In an environment of its own, since gymnax pins Gymnasium:

    pip install gymnax six && pip install -e . -c constraints.txt && taskset -c 0 python examples/beside_gymnax.py
"""

import time

import gymnasium
import numpy as np

import llf_teacher  # noqa: F401  (registers the environments)

try:
    import gymnax
    import jax
except ModuleNotFoundError as error:
    raise SystemExit(f"{error}; install it by: pip install gymnax six") from None

ROWS, STEPS, ROUNDS = 4096, 252, 3


def ours(id: str) -> float:
    """Millions of steps a second of the processor, with all that the teacher says as arrays."""
    envs = gymnasium.make_vec(id, num_envs=ROWS, vectorization_mode="vector_entry_point")
    envs.reset(seed=0)
    envs.reset()  # draws from the pool of houses, which is made now
    actions = np.random.default_rng(0).integers(int(envs.single_action_space.n), size=(STEPS + 1, ROWS))
    envs.step(actions[0])
    begin = time.process_time()
    for each in actions[1:]:
        envs.step(each)
    return STEPS * ROWS / (time.process_time() - begin) / 1e6


def four_rooms() -> tuple[float, float]:
    """The same of gymnax's FourRooms: a compiled step at a time, and all steps as one compiled loop."""
    env, settings = gymnax.make("FourRooms-misc")
    key = jax.random.PRNGKey(0)
    actions = jax.random.randint(key, (STEPS, ROWS), 0, 4)
    keys = jax.random.split(key, STEPS * ROWS).reshape(STEPS, ROWS, -1)
    step = jax.jit(jax.vmap(env.step, (0, 0, 0, None)))
    _, start = jax.jit(jax.vmap(env.reset, (0, None)))(jax.random.split(key, ROWS), settings)

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
        rates.append(STEPS * ROWS / (time.process_time() - begin) / 1e6)
    return rates[0], rates[1]


print("M steps a second: gridworld, bandits, FourRooms step by step, FourRooms in one loop")
for _ in range(ROUNDS):
    rates = ours("llf-gridworld-v0"), ours("llf-bandits-BanditTenArmedRandomFixed-v0"), *four_rooms()
    print("  ".join(f"{rate:.2f}" for rate in rates))
