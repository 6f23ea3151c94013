"""What it costs to play studies at scale: episodes a second by workers and by Ray nodes, and the runner's share.

    python examples/efficiency.py --episodes 4000 --workers 1 2 4 --nodes 1 2

The study is of bandits and gridworld, whose episodes are among the shortest, so that the costs of running and storing
them are seen at their worst. `--nodes` begins that many nodes of a Ray cluster on this machine, of one core each.
"""

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from llf_teacher.episodes.record import pack_turns
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import RunOptions, play_missing
from llf_teacher.studies.store import Store

IDS = ("llf-bandits-BanditTenArmedRandomRandom-v0", "llf-gridworld-v0")
TEACHERS, STUDENTS = ("oracle", "silent"), ("random", "obedient")
SETS = len(IDS) * len(TEACHERS) * len(STUDENTS)


def study(episodes: int) -> Study:
    """So many episodes, or a few more."""
    return Study(ids=IDS, teachers=TEACHERS, students=STUDENTS, seeds=-(-episodes // SETS))


def alone(episodes: int) -> tuple[float, float, float]:
    """Episodes a second of a bare loop; microseconds of a core to play and check an episode, and to pack its turns."""
    specs = list(study(episodes).episodes())
    for spec in specs[:: len(specs) // SETS]:
        play(spec)  # loads what each needs
    playing = packing = 0.0
    start = time.perf_counter()
    for spec in specs:
        begun = time.process_time()
        record = play(spec)
        played = time.process_time()
        pack_turns(record.turns)
        playing += played - begun
        packing += time.process_time() - played
    speed = len(specs) / (time.perf_counter() - start)
    return speed, playing / len(specs) * 1e6, packing / len(specs) * 1e6


def timed(episodes: int, workers: int | None, options: RunOptions) -> tuple[float, float, int]:
    """Episodes a second, microseconds of the parent's core for each, both without the start, and bytes of each."""
    marks: list[tuple[float, float, int]] = []  # at a tenth of the episodes, and at the end

    def progress(done: int, total: int) -> None:
        if len(marks) < 2 and done >= (total // 10, total)[len(marks)]:
            marks.append((time.perf_counter(), time.process_time(), done))

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.db"
        with Store(path) as store:
            play_missing(study(episodes), store, workers, progress, options=options)
        size = os.path.getsize(path) // marks[-1][2]
    (began, busy_before, first), (ended, busy, last) = marks
    return (last - first) / (ended - began), (busy - busy_before) / (last - first) * 1e6, size


def on_nodes(nodes: int, measure: Callable[[str], tuple[float, float, int]]) -> tuple[float, float, int]:
    """Measure on a Ray cluster of so many nodes of one core each."""
    import ray
    from ray.cluster_utils import Cluster

    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    node = {"num_cpus": 1, "object_store_memory": 80_000_000}
    cluster = Cluster(initialize_head=True, head_node_args=node | {"include_dashboard": False})
    try:
        for _ in range(nodes - 1):
            cluster.add_node(**node)
        cluster.wait_for_nodes()
        return measure(cluster.address)
    finally:
        ray.shutdown()
        cluster.shutdown()


def main() -> None:
    """Measure, and print two tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=4000)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 4])
    parser.add_argument("--nodes", type=int, nargs="*", default=[])
    options = parser.parse_args()

    bare, playing, packing = alone(min(options.episodes, 1000))
    print(f"{os.cpu_count()} cores; a bare loop plays {bare:.0f} episodes a second;")
    print(f"{playing:.0f} us of a core to play and check an episode, {packing:.0f} us to pack it\n")
    print("| executor | episodes a second | efficiency | parent, us an episode | overhead | bytes an episode |")
    print("|---|---|---|---|---|---|")
    runs: list[tuple[str, int, Callable[[], tuple[float, float, int]]]] = [
        (f"processes, {n} workers", n, lambda n=n: timed(options.episodes, n, RunOptions("processes")))
        for n in options.workers
    ]
    runs += [
        (
            f"ray, {n} nodes",
            n,
            lambda n=n: on_nodes(n, lambda address: timed(options.episodes, None, RunOptions("ray", address=address))),
        )
        for n in options.nodes
    ]
    for name, cores, measure in runs:
        speed, parent, size = measure()
        efficiency = speed / (min(cores, os.cpu_count() or 1) * bare)
        print(
            f"| {name} | {speed:.0f} | {efficiency:.0%} | {parent:.0f} | {(parent + packing) / playing:.0%} | {size} |",
            flush=True,
        )
    print(f"\nmost memory of the parent: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024} MB")


if __name__ == "__main__":
    main()
