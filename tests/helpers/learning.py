"""What learners of any library are given, and whether they have learned something."""

import numpy as np
from playing import earned, episode

import llf_teacher

GRID, ARMS = "llf-gridworld-v0", "llf-bandits-BanditTenArmedRandomFixed-v0"
HOUSE = {"num_rooms": 8, "min_goal_dist": 2}
"""A small house, which takes little learning."""


def student(id=GRID, **settings):
    """A student's seat in numbers, in which advice is all that is said."""
    if id == GRID:
        settings = {**HOUSE, "until_success": True, **settings}
    return llf_teacher.StudentEnv(id, numbers=True, feedback_type="fp", **settings)


def place(env, name):
    """Where a field's numbers are."""
    (found,) = [field.place for field in env.unwrapped.fields if field.name == name]
    return found


def follows(act, id=GRID, seeds=range(10_000, 10_020)):
    """The share of turns in which what `act` makes of an observation is what is advised; one of four by chance.

    A random policy takes the turns, so that every learner is asked the same.
    """
    env, rng = student(id), np.random.default_rng(0)
    advice = place(env, "fp.action")
    right = turns = 0

    def moved(observation, info):
        nonlocal right, turns
        right += int(act(observation)) == int(observation[advice].argmax())
        turns += 1
        return int(rng.integers(env.action_space.n))

    for seed in seeds:
        earned(env, moved, seed)
    return right / turns


def succeeds(act, seeds=range(10_000, 10_030)):
    """The share of houses in which a policy finds the treasure."""
    env = student()
    ends = [list(episode(env, lambda observation, info: int(act(observation)), seed))[-1] for seed in seeds]
    return sum(info["success"] for *_, info in ends) / len(seeds)
