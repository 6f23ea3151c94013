"""Curricula that are learned while the student learns, beside random tasks and the last task alone.

The student learns a house by tabular Q-learning, and hears nothing. The curriculum chooses where each lesson starts:
next to the treasure, farther away, or at the opening, which the tests ask for.

    python examples/choose_tasks.py --seeds 200
"""

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np

import llf_teacher  # noqa: F401 (registers the environments)
from llf_teacher.registry import family
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.analysis.statistics import mean_interval, paired_difference
from pz_envs.parallel_seats import ParallelSeats
from pz_envs.scripted import SayAll
from pz_envs.seatings.curriculum import CURRICULUM

TASKS = [{"ahead": share} for share in (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.0)]
STUDENT = "q_learning(forget=False, optimism=0.0, epsilon=0.2)"
RATE, GREED = 0.3, 0.8
Choose = Callable[[np.ndarray, dict[str, Any]], int]  # what the curriculum sees, and its info, to the next task


class Edge:
    """Chooses tasks at the edge of what the student can do: a farther start after a success, a nearer one after none.

    So does the reverse curriculum of Florensa et al. 2017, by starts from which the student succeeds now and then.
    """

    def __init__(self, tasks: int, rng: np.random.Generator) -> None:
        self.tasks, self.task = tasks, 0

    def __call__(self, seen: np.ndarray, info: dict[str, Any]) -> int:
        """Learn from the last lesson, and choose the next task."""
        if info["task"] >= 0:
            self.task = int(np.clip(self.task + (1 if info["returns"] > 0 else -1), 0, self.tasks - 1))
        return self.task


class Progress:
    """Prefers tasks in which the student's return changes: Matiisen et al. 2017, the online algorithm."""

    def __init__(self, tasks: int, rng: np.random.Generator) -> None:
        self.rng, self.progress, self.last = rng, np.ones(tasks), np.zeros(tasks)

    def __call__(self, seen: np.ndarray, info: dict[str, Any]) -> int:
        """Learn from the last lesson, and choose the next task."""
        task = info["task"]
        if task >= 0:
            change = abs(info["returns"] - self.last[task])
            self.progress[task] += RATE * (change - self.progress[task])
            self.last[task] = info["returns"]
        if self.rng.random() > GREED:
            return int(self.rng.integers(len(self.progress)))
        return int(np.argmax(self.progress + 1e-6 * self.rng.random(len(self.progress))))


def taught(seed: int, make: Callable[[int, np.random.Generator], Choose], lessons: int) -> float:
    """The share of ten tests from the opening in which the student finds the treasure."""
    gridworld = family("gridworld")
    aec = gridworld.raw_env(
        seating="curriculum", tasks=TASKS, lessons=lessons, tests=10, max_cycles=20, min_goal_dist=8, teacher="silent"
    )
    student = parse_student(STUDENT).seat(gridworld, aec.rooms[0].session.world)
    env = ParallelSeats(aec, {"teacher_0": SayAll(), "student_0": student})
    choose, earned = make(len(TASKS), np.random.default_rng(seed)), 0.0
    seen, infos = env.reset(seed=seed)
    while env.agents:
        seen, rewards, _, _, infos = env.step({CURRICULUM: choose(seen[CURRICULUM], infos[CURRICULUM])})
        earned += rewards[CURRICULUM]
    return earned / 10


def main() -> None:
    """Compare curricula on the same houses."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--lessons", type=int, default=25)
    arguments = parser.parse_args()
    curricula: dict[str, Callable[[int, np.random.Generator], Choose]] = {
        "edge": Edge,
        "progress": Progress,
        "random tasks": lambda tasks, rng: lambda *_: int(rng.integers(tasks)),
        "the last task alone": lambda tasks, _: lambda *_: tasks - 1,
    }
    seeds = range(arguments.seeds)
    found = {name: np.array([taught(i, make, arguments.lessons) for i in seeds]) for name, make in curricula.items()}
    print("| curriculum | successful tests | more than random tasks | p |\n|---|---|---|---|")
    for name, share in found.items():
        gain = paired_difference(share, found["random tasks"])
        print(f"| {name} | {mean_interval(share).text()} | {gain.estimate.text()} | {gain.p:.4f} |")


if __name__ == "__main__":
    main()
