"""When should a teacher spend a small budget of advice? After Torrey & Taylor 2013.

The paper: advice in important states and before mistakes is worth more than early advice, and that more than advice at
random times. Its students play Pac-Man and StarCraft. Here they learn a house of 20 rooms by Q-learning, in 60 episodes
of at most 60 moves from the same room, and take the advised move. A teacher has 10 or 30 pieces of advice for all
episodes together. A seed is a class of 50 students, each in its own house.

Declared before: beside early advice, correcting announced mistakes wastes at least a tenth less, and so does advice by
discounted importance; early advice wastes at least a tenth less than advice at random times; each with both budgets.

    python examples/known_results/budget.py --plot docs/known-budget.png
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from _shared import cell, draw_bars, parsed, played, print_table, print_verdict, saving

import llf_teacher
from llf_teacher.gym.lifetime_statistics import FIELDS

BUDGETS = {10: 4, 30: 8}
"""Of each, the most moves to the treasure at which discounted importance advises, chosen on other seeds."""
STUDENTS, EPISODES, TURNS = 50, 60, 60
STUDENT = "q_learning(trust=1.0, forget=False, optimism=0.0, epsilon=0.1)"
GREATEST = 2.0
"""The most moves between the best and the worst door, since a door changes the distance by one."""
ADVICE = 0b01000
"""The teacher's choice of fp alone."""


class Seen(NamedTuple):
    """What a teacher sees of each student, an array of shape (students,) each."""

    importance: np.ndarray
    """Moves between the best and the worst door."""
    mistake: np.ndarray
    """Whether the student has announced a wrong move."""
    erred: np.ndarray
    """Whether its last move was wrong where most was at stake."""
    way: np.ndarray
    """Moves to the treasure."""
    near: int
    """Within how many moves of it discounted importance advises."""
    rng: np.random.Generator


RULES: dict[str, Callable[[Seen], np.ndarray]] = {
    "announced mistake": lambda seen: seen.mistake & (seen.importance >= GREATEST),
    "correcting": lambda seen: seen.erred,
    "importance": lambda seen: seen.importance >= GREATEST,
    "discounted importance": lambda seen: (seen.importance >= GREATEST) & (seen.way <= seen.near),
    "early": lambda seen: seen.importance >= 0,
    "random": lambda seen: seen.rng.random(STUDENTS) < 0.1,
    "no advice": lambda seen: seen.importance < 0,
}


def measure(budget: int, rule: str, seed: int) -> list[float]:
    """The moves that a class of students wastes, per episode."""
    env = llf_teacher.TeacherVectorEnv(
        "llf-gridworld-v0",
        STUDENTS,
        student=STUDENT,
        episodes=EPISODES,
        max_turns=TURNS,
        feedback_type="fp",
        budget=budget,
        cost=0.0,
        teacher_reward="student_progress",
        announce=True,
        num_rooms=20,
        options={"pool": 1},  # no further house where a student has ended
    )
    observation, _ = env.reset(seed=[*range(seed * STUDENTS, (seed + 1) * STUDENTS)])
    living, wasted, before = np.ones(STUDENTS, bool), 0.0, np.zeros(STUDENTS)
    rng = np.random.default_rng(seed)
    while living.any():
        features = observation["features"]
        life = dict(zip(FIELDS, observation["lifetime"].T.astype(float), strict=True))
        importance, opening = features[:, 2].astype(float), features[:, 0] == 0
        erred = ~opening & (life["optimal"] == 0) & (before >= GREATEST)
        way = np.rint(4 * life["way"] / (1 - life["way"]))
        seen = Seen(importance, life["mistake"] > 0, erred, way, BUDGETS[budget], rng)
        speaks = RULES[rule](seen) & (observation["action_mask"][:, ADVICE] > 0) & living
        before = importance
        observation, reward, terminated, truncated, _ = env.step(np.where(speaks, ADVICE, 0))
        wasted -= reward[living].sum()
        living &= ~(terminated | truncated)
    env.close()
    return [wasted / STUDENTS / EPISODES]


def main() -> None:
    """Teach all classes, print the table and the verdict, draw the plot."""
    given = parsed(__doc__, seeds=12)
    found = played(measure, [(budget, rule) for budget in BUDGETS for rule in RULES], given.seeds)
    wasted = {setting: values[:, 0] for setting, values in found.items()}
    heads = ["teacher", *(f"moves wasted per episode, {budget} pieces" for budget in BUDGETS)]
    print_table(heads, *([rule, *(cell(wasted[budget, rule]) for budget in BUDGETS)] for rule in RULES))
    pairs = [("announced mistake", "early"), ("discounted importance", "early"), ("early", "random")]
    print_verdict(
        [
            saving(f"{rule} wastes less than {than}, {budget} pieces", wasted[budget, rule], wasted[budget, than])
            for budget in BUDGETS
            for rule, than in pairs
        ]
    )
    if given.plot:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7.5, 3.6), layout="constrained")
        axes = figure.subplots()
        groups = [f"{budget} pieces" for budget in BUDGETS]
        draw_bars(axes, groups, {rule: [wasted[budget, rule] for budget in BUDGETS] for rule in RULES})
        axes.set(ylabel="moves wasted per episode")
        figure.legend(loc="outside right center", fontsize="small")
        figure.savefig(given.plot, dpi=120)


if __name__ == "__main__":
    main()
