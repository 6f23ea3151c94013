# ---
# jupytext:
#   text_representation:
#     format_name: percent
# ---

# %% [markdown]
# # A teacher that learns
#
# A student learns its way through a house by itself, by Q-learning. A teacher may say eight times in the student's lifetime
# what to do next. When should it? Here a teacher finds that out: its rule has two numbers, and a search keeps those whose
# students waste least.
#
# Run it with `python docs/quickstart/learning.py`, or open it as a notebook, after
# `pip install -e ".[all,notebook]" -c constraints.txt`. It takes half a minute, and needs no neural network and no GPU.

# %%
import os
from pathlib import Path

import numpy as np

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference

LIVES = int(os.environ.get("LLF_QUICKSTART_LIVES", "80"))  # the tests play fewer
EPISODES, MOVES = 30, 40


def lifetimes(rows: int) -> llf_teacher.TeacherVectorEnv:
    """The teacher's seat in `rows` lifetimes at once, each of 30 episodes in a house of its own."""
    return llf_teacher.TeacherVectorEnv(
        "llf-gridworld-v0",
        rows,
        student="q_learning(forget=False, trust=1.0, optimism=0.0, epsilon=0.1)",  # takes the advice that it gets
        episodes=EPISODES,
        max_turns=MOVES,
        until_success=True,
        budget=8,  # pieces of advice, for all of the lifetime
        cost=0.0,
        feedback_type="fp",  # it can say what to do next, and nothing else
        teacher_reward="student_progress",  # minus the moves that the student wastes
        announce=True,  # the student says first what it means to do
        options={
            "min_goal_dist": 6,  # the treasure is far
            "pool": 4 * LIVES,  # a row that has ended begins anew, in one of so many houses
        },
    )


# %% [markdown]
# ## What a teacher sees and does
#
# Of each lifetime it sees numbers: the turn, how much is at stake (`importance`), what is left of its budget, and what the
# student has done so far. `mistake` is 1 if the student announces a move that is not the best, and `way` grows with the
# moves that are left to the treasure. Its action is `0b01000`, advice, or `0`, silence.

# %%
ADVICE = 0b01000
SEEN = ("turn", "reward", "importance", "budget left", "over", *FIELDS)
MISTAKE = SEEN.index("mistake")
print(len(SEEN), "numbers:", ", ".join(SEEN))


def wasted(speaks, seeds: range | list[int]) -> np.ndarray:
    """Moves that the student wastes in an episode, for each lifetime.

    Args:
        speaks: what is seen, shape (rows, numbers) -> whether to give advice, shape (rows,).
        seeds: one for each lifetime. A seed is a house. What its student tries by chance depends on all the seeds,
            so only equal lists of seeds are equal lifetimes.
    """
    rows = len(seeds)
    envs = lifetimes(rows)
    observations, _ = envs.reset(seed=seeds)
    total, alive = np.zeros(rows), np.ones(rows, dtype=bool)
    while alive.any():
        seen = np.hstack([observations["features"], observations["lifetime"]])
        advised = speaks(seen) & (observations["action_mask"][:, ADVICE] == 1)
        observations, rewards, terminated, truncated, _ = envs.step(
            np.where(advised, ADVICE, 0)
        )
        total += np.where(alive, rewards, 0)
        alive &= ~(terminated | truncated)
    return -total / EPISODES


# %% [markdown]
# Three rules to compare with: silence, advice from the first turn on, and advice where the student announces a mistake.

# %%
RULES = {
    "silence": lambda seen: np.zeros(len(seen), dtype=bool),
    "from the first turn on": lambda seen: np.ones(len(seen), dtype=bool),
    "before every mistake": lambda seen: seen[:, MISTAKE] == 1,
}
for name, rule in RULES.items():
    print(
        f"{name:24} {mean_interval(wasted(rule, range(LIVES))).text()} moves wasted an episode"
    )

# %% [markdown]
# ## The search
#
# The teacher's rule has two numbers: it advises before a mistake if the treasure is at most so many moves away, and if the
# student has been advised in this room at most so many times. Both begin at 10, which is nearly "before every mistake".
# Of twelve candidates a generation the three best are averaged, and the next ones are drawn around that. All candidates
# teach in the same houses, at once in one array: each house stands in twelve rows. What the student tries by chance differs
# from row to row.

# %%
CANDIDATES, GENERATIONS = 12, int(os.environ.get("LLF_QUICKSTART_GENERATIONS", "10"))
NUMBERS = ("way", "advised")


def limited(limits):
    """The rule with these limits, shape (2,), or with those of each candidate, shape (candidates, 2)."""
    limits = np.atleast_2d(limits)

    def speaks(seen):
        shares = seen[:, [SEEN.index(name) for name in NUMBERS]]  # n / (n + 4) each
        counts = 4 * shares / (1 - shares)
        within = counts <= np.repeat(limits, len(seen) // len(limits), axis=0) + 1e-3
        return (seen[:, MISTAKE] == 1) & within.all(axis=1)

    return speaks


rng, best, spread, curve = np.random.default_rng(0), np.full(2, 10.0), 5.0, []
for _ in range(GENERATIONS):
    drawn = np.maximum(best + spread * rng.normal(size=(CANDIDATES, 2)), 0)
    lost = (
        wasted(limited(drawn), [*range(1000, 1000 + LIVES)] * CANDIDATES)
        .reshape(CANDIDATES, LIVES)
        .mean(axis=1)
    )
    best, spread = drawn[np.argsort(lost)[:3]].mean(axis=0), 0.8 * spread
    curve.append(lost.min())
print("It learned:", dict(zip(NUMBERS, best.round(1).tolist(), strict=True)))

# %% [markdown]
# ## Is it better, where it has not learned?
#
# On 160 lifetimes that no candidate was tried on. Each rule teaches the same 160, so the differences are paired:

# %%
import matplotlib.pyplot as plt

held = {
    name: wasted(rule, range(5000, 5000 + 2 * LIVES))
    for name, rule in (RULES | {"learned": limited(best)}).items()
}
for name, lost in held.items():
    more = paired_difference(lost, held["learned"]).estimate
    print(
        f"{name:24} {mean_interval(lost).text()} moves wasted an episode; more than the learned teacher {more.text()}"
    )

figure, (learning, compared) = plt.subplots(1, 2, figsize=(9, 2.6), layout="constrained")
learning.plot(range(1, GENERATIONS + 1), curve)
learning.set(xlabel="generation", ylabel="moves wasted, the best", ylim=(0, None))
for row, lost in enumerate(held.values()):
    estimate = mean_interval(lost)
    if not estimate.why:
        compared.plot([estimate.low, estimate.high], [row, row], color="tab:blue")
    compared.plot(estimate.mean, row, "o", color="tab:blue")
compared.set(
    yticks=range(len(held)),
    yticklabels=held,
    xlabel="moves wasted an episode, new lifetimes",
    xlim=(0, None),
)
file = Path("quickstart-learning.png").resolve()
figure.savefig(file, dpi=150)
print(f"Figure: {file}")
plt.show()

# %% [markdown]
# Why near the treasure? Q-learning passes a value on by one room a visit, from the treasure outwards: advice close to it is worth
# most for the episodes to come. [A teacher that learned](../internals/learn-to-teach.md) has the same for other budgets, students and
# learners. The seat for your own algorithm: [Train a teacher](../train-teachers.md).
# Next: [an agent that is taught](agent.py).
