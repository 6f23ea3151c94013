"""Play fresh episodes in processes of their own, and compare their times."""

import math
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from itertools import count, islice
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from llf_teacher.episodes.loop import play_turns
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from llf_teacher.tools.benchmark import player
from llf_teacher.tools.benchmark.player import Script, Times

BLOCKS = 8
"""Number of blocks that are measured."""
_FIRST = 100_000  # nothing else uses seeds from here on


class Call(NamedTuple):
    """A kind of work: one of `player.FORMS`, and its arguments after the scripts."""

    form: str
    arguments: tuple[Any, ...] = ()


class Player:
    """A process that plays scripts for one kind of work; close it after use."""

    def __init__(self, call: Call, tree: Path | None = None) -> None:
        """Start the process; `tree` is a folder with other packages to import than the running ones."""
        # Earlier revisions compile the car park's plans where numba is installed; they are compared without it.
        environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
        if tree is not None:
            environment["PYTHONPATH"] = str(tree)
        self._call = call
        command = [sys.executable, "-P", player.__file__]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)  # noqa: S603

    def close(self) -> None:
        """End the process."""
        self._process.communicate()

    def play(self, scripts: Sequence[Script]) -> tuple[Any, ...]:
        """Play episodes and return their times, or their records.

        Raises:
            RuntimeError: the process has ended; its messages are on standard error.
        """
        calls, answers = self._process.stdin, self._process.stdout
        assert calls is not None  # noqa: S101  # both are pipes
        assert answers is not None  # noqa: S101
        try:
            pickle.dump((self._call.form, (scripts, *self._call.arguments)), calls)
            calls.flush()
            return tuple(pickle.load(answers))  # noqa: S301  # from a process of ours
        except (BrokenPipeError, EOFError):
            raise RuntimeError(f"the process that plays {self._call} has ended; see its messages above") from None


class Writer:
    """Writes scripts of one environment, each with an unused seed."""

    def __init__(self, id: str, student: str) -> None:
        """`student` is the spec of the student whose actions become the script."""
        policy = parse_student(student)
        self._env = make(id, text=policy.text)
        self._student = policy.seat(self._env.family, self._env.session.world)
        self._seeds = count(_FIRST)

    def write(self, steps: int) -> list[Script]:
        """Episodes with `steps` steps in all; the last one is cut short."""
        scripts: list[Script] = []
        while steps > 0:
            scripts.append(self.episode(steps))
            steps -= len(scripts[-1][1])
        return scripts

    def episode(self, most: int) -> Script:
        """An episode of at most `most` steps."""
        seed = next(self._seeds)
        return seed, self._actions(seed, most)

    def _actions(self, seed: int, most: int) -> list[Any]:
        played = play_turns(self._env, self._student, seed)
        return [turn.moment.action for turn in islice(played, most + 1)][1:]


class Measured(NamedTuple):
    """The times of one kind of work, in seconds."""

    blocks: list[Times]

    @property
    def cpu(self) -> float:
        """Mean CPU time of a step."""
        return sum(block.cpu for block in self.blocks) / len(self.steps)

    @property
    def steps(self) -> list[float]:
        """Wall time of each step."""
        return [step for block in self.blocks for step in block.steps]

    @property
    def reset(self) -> float:
        """Mean wall time of a reset."""
        return float(np.mean([reset for block in self.blocks for reset in block.resets]))

    @property
    def peak(self) -> float:
        """Peak memory of the process, in MB."""
        return max(block.peak for block in self.blocks)


class Ratio(NamedTuple):
    """Time of one kind of work divided by that of another, with a 95 % interval."""

    mean: float
    low: float
    high: float


def measure(
    calls: Mapping[str, tuple[Call, Path | None]], scripts: Mapping[str, Sequence[Sequence[Script]]]
) -> dict[str, Measured]:
    """Play blocks of scripts alternately, so that a change of the machine's speed affects all kinds of work.

    Args:
        calls: by name, the work, and the folder of its packages or None for the running packages.
        scripts: by the same names, the blocks; the first one is a warm-up and is not counted.
    """
    players: dict[str, Player] = {}
    times: dict[str, list[Times]] = {name: [] for name in calls}
    try:
        for name, (call, tree) in calls.items():
            players[name] = Player(call, tree)
        for block in range(min(len(each) for each in scripts.values())):
            for name in list(players)[:: 1 if block % 2 else -1]:  # the order changes, so that none is always first
                times[name].append(Times(*players[name].play(scripts[name][block])))
    finally:
        for each in players.values():
            each.close()
    return {name: Measured(each[1:]) for name, each in times.items()}


Runs = Sequence[Mapping[str, Measured]]
"""The measurements of each run, by the names of the work."""


def measure_runs(
    calls: Mapping[str, tuple[Call, Path | None]], scripts: Mapping[str, Sequence[Sequence[Script]]], runs: int
) -> Runs:
    """Measure in several runs, in new processes each time: two processes of the same code can differ by a third."""
    return [measure(calls, scripts) for _ in range(runs)]


def spread(figures: Sequence[float], form: Callable[[float], str] = "{:.2f}".format) -> str:
    """The median of the runs' figures; of several with their range, as in "1.60 (1.52 to 2.01)"."""
    low, middle, high = (form(each(figures)) for each in (min, median, max))
    return middle if low == high else f"{middle} ({low} to {high})"


def ratio(new: Measured, old: Measured) -> Ratio:
    """The geometric mean of the blocks' ratios of CPU time, with Student's t interval of the logarithms."""
    logs = [math.log(a.cpu / len(a.steps) * len(b.steps) / b.cpu) for a, b in zip(new.blocks, old.blocks, strict=True)]
    interval = stats.ttest_1samp(logs, 0).confidence_interval(0.95)
    return Ratio(*(math.exp(each) for each in (np.mean(logs), interval.low, interval.high)))
