"""How long a report of a study takes, and how large it gets.

    python examples/big_report.py --episodes 1000000

Of each teacher with each student in each family one episode is played; the others are that one with regrets of their
own, and without turns, which a report does not read. The study is the quickstart's, slow simulators left out.
"""

import argparse
import resource
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from llf_teacher.episodes.record import pack_regrets, pack_turns, unpack_regrets
from llf_teacher.studies.definition.study import Study, quickstart
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.report import write_report
from llf_teacher.studies.store import Store


def fill(store: Store, study: Study) -> None:
    """Store every episode of the study."""
    rng = np.random.default_rng(0)
    for spec in study.episodes():
        if spec.seed == 0:
            record = play(spec)
            regrets = unpack_regrets(record.episode.regrets)
            store.add(record)
            continue
        mine = (regrets * rng.exponential(size=len(regrets))).tolist()
        success = bool(rng.random() < 0.5 + 0.5 * record.episode.success)
        row = record.episode._replace(regret=sum(mine), regrets=pack_regrets(mine), success=success)
        store.add_packed(spec, row, pack_turns(()))


def main() -> None:
    """Fill a store, write the report, print what it took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=30_000)
    parser.add_argument("--families", type=int, help="so many of them; all by default")
    parser.add_argument("--keep", type=Path, help="keep store and report in this folder; a store that is there is used")
    arguments = parser.parse_args()
    whole = quickstart()
    ids = [id for id in whole.ids if id not in whole.fewer][: arguments.families]
    cells = len(ids) * len(whole.teachers) * len(whole.students)
    study = Study(ids=ids, teachers=whole.teachers, students=whole.students, seeds=-(-arguments.episodes // cells))
    with TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        path, report = folder / f"{arguments.episodes}.db", folder / f"{arguments.episodes}.html"
        there = path.exists()
        with Store(path) as store:
            if not there:
                with store.together():
                    fill(store, study)
            wall, processor = time.perf_counter(), time.process_time()
            before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
            write_report(store, study, report)
            wall, processor = time.perf_counter() - wall, time.process_time() - processor
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(f"{cells * len(study.seeds):,} episodes in {len(ids)} families")
        print(f"{wall:.0f} s, {processor:.0f} s of processor")
        print(f"{peak / 1024:.0f} MB at most, {before / 1024:.0f} MB before the report")
        print(f"{report.stat().st_size / 1e6:.1f} MB of HTML")


if __name__ == "__main__":
    main()
