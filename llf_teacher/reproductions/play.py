"""Playing rows: what is not stored is measured in parallel processes, and stored as it ends."""

import json
import math
import multiprocessing
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import NamedTuple

import numpy as np

import llf_teacher
from llf_teacher.reproductions.row import FIRST_SEED, QUICK, Row, Setting, Values, all_rows, digest


class Task(NamedTuple):
    """One measurement."""

    row: str
    setting: Setting
    seed: int

    @property
    def key(self) -> str:
        """What it is stored under; another version of this package measures anew."""
        return f"{llf_teacher.__version__}/{self.row}/{digest(self.setting)}/{self.seed}"


def tasks(name: str, row: Row, quick: bool) -> list[Task]:
    """Every measurement of a row."""
    seeds = range(FIRST_SEED, FIRST_SEED + (min(QUICK, row.seeds) if quick else row.seeds))
    return [Task(name, setting, seed) for seed in seeds for setting in row.settings]


class Measurement(NamedTuple):
    """What a measurement gave."""

    numbers: list[float]
    seconds: float
    """CPU time that it took."""


def load(path: Path) -> dict[str, Measurement]:
    """What is stored; a last line that was cut off is left out, since it will be measured again."""
    found: dict[str, Measurement] = {}
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines(keepends=True):
            if line.endswith("\n"):
                found.update({key: Measurement(*each) for key, each in json.loads(line).items()})
    return found


def play(
    rows: Mapping[str, Row], path: Path, quick: bool = False, report: Callable[[str, int, int], None] | None = None
) -> dict[str, Values]:
    """Measure what the file lacks, append it, and give the values of all rows.

    Args:
        rows: by name.
        path: a file of JSON lines; one line a measurement, appended as it ends, so that nothing is lost.
        quick: whether only a few seeds are played.
        report: called with a row's name, its measurements that are there, and all of them.
    """
    there = load(path)
    todo = {name: tasks(name, row, quick) for name, row in rows.items()}
    if path.exists() and not path.read_bytes().endswith(b"\n"):  # what was cut off
        path.write_text("".join(f"{json.dumps({key: value})}\n" for key, value in there.items()), encoding="utf-8")
    context = multiprocessing.get_context("spawn")
    with path.open("a", encoding="utf-8") as file, ProcessPoolExecutor(mp_context=context) as pool:
        for name, asked in todo.items():
            missing = [task for task in asked if task.key not in there]
            done = len(asked) - len(missing)
            futures = {pool.submit(_measure, *task): task for task in missing}
            for future in as_completed(futures):
                there[futures[future].key] = found = future.result()
                file.write(json.dumps({futures[future].key: found}) + "\n")
                file.flush()
                done += 1
                if report:
                    report(name, done, len(asked))
    return {name: _values(asked, there) for name, asked in todo.items()}


def _measure(name: str, setting: Setting, seed: int) -> Measurement:
    begun = time.process_time()
    row = all_rows()[name]
    numbers = [float(number) for number in row.measure(**setting, seed=seed)]
    if len(numbers) != len(row.measures):
        raise ValueError(f"the row {name} must give {len(row.measures)} numbers, its measures, got {len(numbers)}")
    return Measurement(numbers, round(time.process_time() - begun, 3))


def _values(asked: Sequence[Task], there: Mapping[str, Measurement]) -> Values:
    by_setting: dict[str, list[list[float]]] = {}
    for task in asked:
        by_setting.setdefault(digest(task.setting), []).append(there[task.key].numbers)
    seconds = math.fsum(there[task.key].seconds for task in asked)
    return Values({key: np.array(rows) for key, rows in by_setting.items()}, seconds)
