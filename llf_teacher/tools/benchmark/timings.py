"""The tables of `llf dev benchmark`: each row compares fresh work with a reference, measured in the same runs.

A figure is the median of the runs, with the lowest and the highest in brackets where it is a mean CPU time or a ratio.
"""

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from itertools import chain, product
from statistics import median

import numpy as np
from gymnasium.spaces import Discrete
from rich.table import Table

from llf_teacher.registry import PREFIX
from llf_teacher.tools.benchmark.measuring import BLOCKS, Call, Runs, Writer, measure_runs, spread
from llf_teacher.tools.benchmark.player import Script
from pz_envs.family import Family, all_families

STUDENTS = {"random": "random", "advised": "obedient"}
"""Name in the tables -> spec of the student whose actions are played."""
_STEPS = 300
_STEPS_OF_SLOW = 30
_STEPS_OF_ORIGINALS = 100
_CLASSES = (1, 8, 64)
_BASE = "gymnasium, pettingzoo"
_TIMES = "CPU us", "wall us", "median", "99 %"
RUNS = 5
"""Number of runs of a table."""
Progress = Callable[[str], None]
"""Called with the name of the next work."""


def steps_of(family: Family, most: int = _STEPS) -> int:
    """Number of steps in a block."""
    return min(most, _STEPS_OF_SLOW) if family.slow else most


def blocks_of(id: str, student: str, steps: int) -> list[list[Script]]:
    """Blocks of scripts, one of them for the warm-up."""
    writer = Writer(id, student)
    return [writer.write(steps) for _ in range(BLOCKS + 1)]


def _tries(steps: int) -> list[list[Script]]:
    """Scripts of random actions for FrozenLake, whose seeds serve tictactoe."""
    rng = np.random.default_rng(0)
    episodes = max(steps // 8, 1)  # an episode has about 8 steps
    return [
        [(int(rng.integers(2**31)), rng.integers(4, size=100).tolist()) for _ in range(episodes)]
        for _ in range(BLOCKS + 1)
    ]


def steps(families: Sequence[Family], progress: Progress, runs: int = RUNS) -> Table:
    """Steps of `make(...)` with all feedback and with none, beside FrozenLake's; ratios are of CPU time.

    `teaching` is the share of feedback in the time of a step.
    """
    table = _table(
        "Steps, all feedback",
        ("environment", "actions"),
        *_TIMES, "/ FrozenLake", "silent / FrozenLake", "teaching", "reset us", "peak MB",
    )  # fmt: skip
    for family in families:
        id = PREFIX + family.showcase[0]
        for name, student in STUDENTS.items():
            progress(f"{id}, {name} actions")
            blocks = blocks_of(id, student, steps_of(family))
            calls = {"lake": Call("lake"), "all": Call("student", (id, "a")), "none": Call("student", (id, "n"))}
            scripts = dict.fromkeys(calls, blocks) | {"lake": _tries(_STEPS)}
            found = measure_runs({name: (call, None) for name, call in calls.items()}, scripts, runs)
            table.add_row(
                id,
                name,
                *_times(found, "all"),
                _ratio(found, "all", "lake"),
                _ratio(found, "none", "lake"),
                _teaching(found),
                *_resets(found, "all"),
            )
    return table


def worlds(families: Sequence[Family], progress: Progress, runs: int = RUNS) -> Table:
    """Steps of bare worlds, beside the environments of other packages that they reimplement."""
    table = _table("Worlds, random actions", ("environment",), "CPU, us", "the original's, us", "ratio")
    for family in families:
        id = PREFIX + family.showcase[0]
        progress(f"{id}, world")
        calls: dict[str, tuple[Call, None]] = {"world": (Call("world", (id,)), None)}
        if family.make_world(**family.environments[family.showcase[0]]).original([], 0) is not None:
            calls["original"] = Call("original", (id,)), None
        blocks = blocks_of(id, "random", steps_of(family, _STEPS_OF_ORIGINALS))
        found = measure_runs(calls, dict.fromkeys(calls, blocks), runs)
        other = (_cpu(found, "original"), _ratio(found, "world", "original", "{:.3f}")) if "original" in calls else ()
        table.add_row(id, _cpu(found, "world"), *other)
    return table


def seats(families: Sequence[Family], progress: Progress, runs: int = RUNS) -> Table:
    """Turns of the bare AEC environments with all feedback, beside PettingZoo's tictactoe."""
    table = _table(
        'Seats, speech="kinds"', ("raw_env", "actions"), *_TIMES, "tictactoe / this", "teaching", "reset us", "peak MB"
    )
    for family in families:
        id = PREFIX + family.showcase[0]
        for name, student in STUDENTS.items():
            progress(f"{id}, seats, {name} actions")
            calls = {
                "tictactoe": Call("tictactoe"),
                "all": Call("seats", (id, "raw_env")),
                "none": Call("seats", (id, "raw_env", 0, True)),
            }
            scripts = dict.fromkeys(calls, blocks_of(id, student, steps_of(family))) | {"tictactoe": _tries(_STEPS)}
            found = measure_runs({key: (call, None) for key, call in calls.items()}, scripts, runs)
            table.add_row(
                id,
                name,
                *_times(found, "all"),
                _ratio(found, "tictactoe", "all"),
                _teaching(found),
                *_resets(found, "all"),
            )
    return table


def simple_families() -> list[Family]:
    """The families whose first environment has finitely many actions."""
    spaces = ((f, f.make_world(**f.environments[f.showcase[0]]).action_space) for f in all_families() if not f.slow)
    return [family for family, space in spaces if isinstance(space, Discrete)]


def forms(progress: Progress, runs: int = RUNS) -> Table:
    """Turns of every form of the seats, in families with finitely many actions, whose worlds cost least.

    A turn is one of a teacher or of a student; a step of a Gymnasium environment has one of each. In a classroom the
    teacher speaks to every student in every round; `per student` is the cost of a student's turn and of the feedback
    to it, relative to a class of one. CPU times are of a turn; wall times are of a call, that is a turn or a step.
    """
    table = _table(
        'Forms of the seats, speech="kinds"',
        ("form", "actions"),
        *_TIMES, "tictactoe / this", "per student", "reset us", "peak MB",
    )  # fmt: skip
    for family, (name, student) in product(simple_families(), STUDENTS.items()):
        id = PREFIX + family.showcase[0]
        progress(f"{id}, forms, {name} actions")
        calls = {
            "tictactoe": Call("tictactoe"),
            "raw_env": Call("seats", (id, "raw_env")),
            "env": Call("seats", (id, "env")),
            "StudentEnv": Call("student", (id, "a")),
            "TeacherEnv": Call("teacher", (id,)),
            **{f"ClassroomEnv({n})": Call("seats", (id, "raw_env", n)) for n in _CLASSES},
        }
        blocks = dict.fromkeys(calls, blocks_of(id, student, _STEPS)) | {"tictactoe": _tries(_STEPS)}
        found = measure_runs({form: (call, None) for form, call in calls.items()}, blocks, runs)
        for form in calls:
            if form != "tictactoe":
                turns = 2 if form in ("StudentEnv", "TeacherEnv") else 1
                table.add_row(
                    f"{family.showcase[0]} {form}",
                    name,
                    spread([each[form].cpu / turns for each in found], _us),
                    *_times(found, form)[1:],
                    spread([each["tictactoe"].cpu / each[form].cpu * turns for each in found]),
                    _ratio(found, form, f"ClassroomEnv({_CLASSES[0]})") if "Classroom" in form else "",
                    *_resets(found, form),
                )
    return table


def imports(progress: Progress) -> Table:
    """CPU time to import this package in a fresh interpreter, beside that of Gymnasium and PettingZoo.

    A first import, which does not count, writes the bytecode.
    """
    progress("imports")
    programs = {_BASE: f"import {_BASE}", "llf_teacher": "import llf_teacher"}
    seconds: dict[str, list[float]] = {name: [] for name in programs}
    with tempfile.TemporaryDirectory() as bytecode:
        environment = os.environ | {"PYTHONPYCACHEPREFIX": bytecode, "PYTHONDONTWRITEBYTECODE": ""}
        for name in chain(*[programs] * (1 + 2 * BLOCKS)):
            begin = _cpu_of_children()
            subprocess.run([sys.executable, "-c", programs[name]], check=True, env=environment)  # noqa: S603
            seconds[name].append(_cpu_of_children() - begin)
    bare, ours = (each[1:] for each in seconds.values())
    ratios = sorted(b / a for a, b in zip(bare, ours, strict=True))
    table = _table("Imports", ("import",), "median, s", "ratio", "ratios")
    table.add_row(_BASE, f"{median(bare):.2f}", "1.00", "")
    table.add_row("llf_teacher", f"{median(ours):.2f}", f"{median(ratios):.2f}", f"{ratios[0]:.2f} to {ratios[-1]:.2f}")
    return table


def _cpu_of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _cpu(found: Runs, name: str) -> str:
    """The mean CPU time of a step."""
    return spread([each[name].cpu for each in found], _us)


def _times(found: Runs, name: str) -> tuple[str, str, str, str]:
    """Cells: mean CPU time of a step, then its mean, median and 99th percentile of wall time."""
    steps = [each[name].steps for each in found]
    mean, middle, slow = zip(*((np.mean(run), np.median(run), np.quantile(run, 0.99)) for run in steps), strict=True)
    return _cpu(found, name), _us(median(mean)), _us(median(middle)), _us(median(slow))


def _resets(found: Runs, name: str) -> tuple[str, str]:
    """Cells: wall time of a reset, and peak memory in MB."""
    return _us(median(each[name].reset for each in found)), f"{median(each[name].peak for each in found):.0f}"


def _ratio(found: Runs, name: str, other: str, form: str = "{:.2f}") -> str:
    """The CPU time of a step divided by that of another kind of work in the same run."""
    return spread([each[name].cpu / each[other].cpu for each in found], form.format)


def _teaching(found: Runs) -> str:
    """The share of feedback in the time of a step."""
    return f"{median(1 - each['none'].cpu / each['all'].cpu for each in found):.0%}"


def _us(seconds: float) -> str:
    return f"{seconds * 1e6:,.0f}" if seconds >= 1e-4 else f"{seconds * 1e6:.1f}"


def _table(title: str, names: Sequence[str], *figures: str) -> Table:
    table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    for name in names:
        table.add_column(name, no_wrap=True)
    for figure in figures:
        table.add_column(figure, justify="right")
    return table
