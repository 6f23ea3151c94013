"""How often a student who follows every advice solves each task of Meta-World, as a table.

python examples/robot_arm.py --controls absolute teacher_event --seeds 0 10
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import llf_teacher
from llf_teacher.students.parsing import parse_student


def solved(id: str, control: str, seeds: range) -> list[int | None]:
    """Per seed the turn in which the task was solved, or None."""
    env = llf_teacher.make(id, feedback_type="fp", control=control)
    student = parse_student("obedient").seat(env.family, env.session.world)
    turns = []
    for seed in seeds:
        student.reset(np.random.default_rng(seed))
        env.reset(seed=seed)
        while not env.session.moment.success and not env.session.moment.over:
            env.step(student.act(env.student_view.observe(), env.student_view.info_for(student)))
        turns.append(env.session.moment.turn if env.session.moment.success else None)
    return turns


def main() -> None:
    """Play, and print a row per task and the total."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ids", nargs="+", default=[id for id in llf_teacher.ids() if "-metaworld-" in id])
    parser.add_argument("--controls", nargs="+", default=["absolute", "teacher_event"])
    parser.add_argument("--seeds", nargs=2, type=int, default=(0, 10), metavar=("FIRST", "END"))
    arguments = parser.parse_args()
    seeds = range(*arguments.seeds)
    cells = [(id, control) for id in arguments.ids for control in arguments.controls]
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    print(f"| of {len(seeds)} seeds from {seeds[0]} | {' | '.join(arguments.controls)} |")
    print("|---|" + "---|" * len(arguments.controls))
    total: dict[str, list[int | None]] = {control: [] for control in arguments.controls}
    with ProcessPoolExecutor() as pool:
        found = dict(zip(cells, pool.map(solved, *zip(*cells, strict=True), [seeds] * len(cells)), strict=True))
    for id in arguments.ids:
        print(f"| {id} | {' | '.join(cell(found[id, control]) for control in arguments.controls)} |")
        for control in arguments.controls:
            total[control] += found[id, control]
    rates = [f"{100 * np.mean([turn is not None for turn in total[c]]):.1f} %" for c in arguments.controls]
    print(f"| all | {' | '.join(rates)} |")


def cell(turns: list[int | None]) -> str:
    """How many were solved, and the mean turn."""
    won = [turn for turn in turns if turn is not None]
    return f"{len(won)} ({np.mean(won):.1f})" if won else "0"


if __name__ == "__main__":
    main()
