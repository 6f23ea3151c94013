"""Plays rows: missing measurements are made in parallel processes, and stored as they end."""

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
from llf_teacher.reproductions.row import FIRST_SEED, QUICK, Row, Values, all_rows, digest
from llf_teacher.reproductions.rule import Setting


class Task(NamedTuple):
    """One measurement."""

    row: str
    setting: Setting
    seed: int

    @property
    def key(self) -> str:
        """The key in the store; another version of this package has other keys."""
        return f"{llf_teacher.__version__}/{self.row}/{digest(self.setting)}/{self.seed}"


def tasks(name: str, row: Row, quick: bool) -> list[Task]:
    """Every measurement of a row."""
    seeds = range(FIRST_SEED, FIRST_SEED + (min(QUICK, row.rule.seeds) if quick else row.rule.seeds))
    return [Task(name, setting, seed) for seed in seeds for setting in row.settings]


class Measurement(NamedTuple):
    """The result of a measurement."""

    numbers: list[float]
    seconds: float
    """CPU time."""


def load(path: Path) -> dict[str, Measurement]:
    """The stored measurements; an incomplete last line is ignored."""
    found: dict[str, Measurement] = {}
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines(keepends=True):
            if line.endswith("\n"):
                found.update({key: Measurement(*each) for key, each in json.loads(line).items()})
    return found


def play(
    rows: Mapping[str, Row], path: Path, quick: bool = False, report: Callable[[str, int, int], None] | None = None
) -> dict[str, Values]:
    """Make the measurements that the file lacks, append them, and give the values of all rows.

    Args:
        rows: by name.
        path: a file of JSON lines, one per measurement, which is appended as it ends.
        quick: whether only a few seeds are played.
        report: called with a row's name, the number of its measurements so far, and their total.
    """
    there = load(path)
    todo = {name: tasks(name, row, quick) for name, row in rows.items()}
    if path.exists() and not path.read_bytes().endswith(b"\n"):  # an incomplete line
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
