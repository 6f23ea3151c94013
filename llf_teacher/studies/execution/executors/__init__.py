"""Executors: engines that play episodes side by side, a module each, found by its name.

An engine knows no study: it calls a function on tasks, in processes of its own, and says what came of each. Who calls
it knows no engine: `start` gives one, and that has three methods.
"""

import os
import pkgutil
from collections.abc import Callable, Hashable
from importlib import import_module
from types import TracebackType
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar

from teachers.spec import unknown

T = TypeVar("T", bound=Hashable)
R = TypeVar("R")
AHEAD = 3
"""Tasks under way for each that is played: enough to keep processes busy, few to lose."""
NAMES = tuple(sorted({module.name for module in pkgutil.iter_modules(__path__)} - {"batches"}))
"""Every executor."""
HERE = frozenset({"here", "threads"})
"""Those that play in this process, where what a notebook or a program defines itself is at hand."""

SPOILED = 77
"""Exit status of a process that an earlier task has spoiled: the task that it has taken is for another process."""


class Work(NamedTuple, Generic[T, R]):
    """What an engine does in each of its processes. All of it must survive the way there."""

    begin: Callable[[], object]
    """Is called first, once a process."""
    call: Callable[[T], R]
    """Is called on each task; it raises nothing."""
    tasks: int
    """How many there will be."""
    seconds: float | None = None
    """How long a call may take before its process is ended, unless it ends by itself."""


class Process:
    """What is to be known of this process."""

    owned = False
    """Whether it is an engine's own, which may be ended."""
    spoiled = False
    """Whether a task was ended in the middle of it, or may hold much memory: better play the next one elsewhere."""

    @classmethod
    def replace(cls) -> None:
        """Let the engine play what this process has been given in a fresh one."""
        if cls.owned:
            os._exit(SPOILED)


class Lost(NamedTuple):
    """Of a task that its process took with it."""

    reason: str
    """`time`, `memory` or `died`."""
    error: str


class Executor(Protocol[T, R]):
    """Tasks go in by `submit`, come out by `wait`, in any order. Leaving the context ends all by force."""

    @property
    def room(self) -> int:
        """How many tasks should be under way, so that it never has to wait for more."""

    def submit(self, task: T) -> None:
        """Take a task, to be played when there is room."""

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        """What has come of tasks since the last call; if nothing yet, wait for it so long. None: it was dropped."""

    def cancel(self) -> list[T]:
        """Drop the tasks that have not begun, or all, of engines that do not know; say which, or let `wait` say it."""

    def __enter__(self) -> Self:
        """The engine itself."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all processes, and what they play, within seconds."""


class ExecutorError(RuntimeError):
    """An engine cannot work; this has nothing to do with a task."""


def start(name: str, work: Work[T, R], workers: int | None = None, address: str | None = None) -> Executor[T, R]:
    """An executor by its name.

    Args:
        name: one of `NAMES`.
        work: what it does.
        workers: how many tasks it plays at once, at most; None: as many as there are cores.
        address: where a cluster is, for those that have one.

    Raises:
        ValueError: an unknown name, or arguments that it has no use for.
        ModuleNotFoundError: it needs a package that is not installed; the message says which.
    """
    if name not in NAMES:
        raise ValueError(unknown("executor", name, NAMES))
    module: Any = import_module(f"{__name__}.{name}")
    executor: Executor[T, R] = module.start(work, workers, address)
    return executor
