"""Fresh work, played by processes of their own, and what their times say."""

import math
import os
import pickle
import subprocess
import sys
from collections.abc import Mapping, Sequence
from itertools import count, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from llf_teacher.episodes.play import play
from llf_teacher.gym import make
from llf_teacher.students.parsing import parse_student
from llf_teacher.tools.benchmark import player
from llf_teacher.tools.benchmark.player import Script, Times

BLOCKS = 8
"""How often what is compared takes turns."""
_FIRST = 100_000  # of the seeds, which nothing else uses


class Call(NamedTuple):
    """What a process is to play: one of `player.FORMS`, and its arguments after the scripts."""

    form: str
    arguments: tuple[Any, ...] = ()
    compiled: bool = False
    """Whether by the extra `fast`, where that can be; all else is measured without it."""


class Player:
    """A process that plays scripts of one kind; to be closed."""

    def __init__(self, call: Call, tree: Path | None = None) -> None:
        """Begin the process; with `tree`, that of the packages in a folder, in place of those that run now."""
        environment = os.environ | {"NUMBA_DISABLE_JIT": str(int(not call.compiled))}
        if tree is not None:
            environment["PYTHONPATH"] = str(tree)
        self._call = call
        command = [sys.executable, "-P", player.__file__]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)  # noqa: S603

    def close(self) -> None:
        """End the process."""
        self._process.communicate()

    def play(self, scripts: Sequence[Script]) -> tuple[Any, ...]:
        """Times of some episodes, or their records.

        Raises:
            RuntimeError: the process ended; what it said is on the standard error stream.
        """
        calls, answers = self._process.stdin, self._process.stdout
        assert calls is not None  # noqa: S101  # both are pipes
        assert answers is not None  # noqa: S101
        try:
            pickle.dump((self._call.form, (scripts, *self._call.arguments)), calls)
            calls.flush()
            return tuple(pickle.load(answers))  # noqa: S301  # of a process of ours
        except (BrokenPipeError, EOFError):
            raise RuntimeError(f"the process that plays {self._call} has ended: see what it said above") from None


class Writer:
    """Writes scripts of one environment: nobody has played their seeds and actions before."""

    def __init__(self, id: str, student: str) -> None:
        """`student` is a spec: whose actions they are."""
        policy = parse_student(student)
        self._env = make(id, text=policy.text)
        self._student = policy.seat(self._env.family, self._env.session.world)
        self._seeds = count(_FIRST)

    def write(self, steps: int) -> list[Script]:
        """Episodes of so many steps together; the last one is cut short."""
        scripts: list[Script] = []
        while steps > 0:
            scripts.append(self.episode(steps))
            steps -= len(scripts[-1][1])
        return scripts

    def episode(self, most: int) -> Script:
        """An episode of that many steps, or less."""
        seed = next(self._seeds)
        return seed, self._actions(seed, most)

    def _actions(self, seed: int, most: int) -> list[Any]:
        played = play(self._env, self._student, seed)
        return [turn.moment.action for turn in islice(played, most + 1)][1:]


class Measured(NamedTuple):
    """All times of one kind of work, in seconds."""

    blocks: list[Times]

    @property
    def cpu(self) -> float:
        """Mean of a step, on the processor."""
        return sum(block.cpu for block in self.blocks) / len(self.steps)

    @property
    def steps(self) -> list[float]:
        """Of each step, on the clock."""
        return [step for block in self.blocks for step in block.steps]

    @property
    def reset(self) -> float:
        """Mean of a reset, on the clock."""
        return float(np.mean([reset for block in self.blocks for reset in block.resets]))

    @property
    def peak(self) -> float:
        """MB that the process used at most."""
        return max(block.peak for block in self.blocks)


class Ratio(NamedTuple):
    """How much longer one kind of work takes than another, with a 95 % interval."""

    mean: float
    low: float
    high: float


def measure(
    calls: Mapping[str, tuple[Call, Path | None]], scripts: Mapping[str, Sequence[Sequence[Script]]]
) -> dict[str, Measured]:
    """Play blocks of scripts in turns, so that all share the machine's moods.

    Args:
        calls: by name, what is timed, and the folder of its packages or None for those that run now.
        scripts: by the same names, the blocks; the first one warms up and is not counted.
    """
    players: dict[str, Player] = {}
    times: dict[str, list[Times]] = {name: [] for name in calls}
    try:
        for name, (call, tree) in calls.items():
            players[name] = Player(call, tree)
        for block in range(min(len(each) for each in scripts.values())):
            for name in list(players)[:: 1 if block % 2 else -1]:  # nobody is always the first
                times[name].append(Times(*players[name].play(scripts[name][block])))
    finally:
        for each in players.values():
            each.close()
    return {name: Measured(each[1:]) for name, each in times.items()}


def ratio(new: Measured, old: Measured) -> Ratio:
    """The geometric mean of the blocks' ratios of time on the processor, with Student's interval of its logarithm."""
    logs = [math.log(a.cpu / len(a.steps) * len(b.steps) / b.cpu) for a, b in zip(new.blocks, old.blocks, strict=True)]
    interval = stats.ttest_1samp(logs, 0).confidence_interval(0.95)
    return Ratio(*(math.exp(each) for each in (np.mean(logs), interval.low, interval.high)))
