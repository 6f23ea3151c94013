"""Executors: engines that play episodes in parallel, one module each, found by its name.

An engine does not depend on studies: it calls a function on tasks, in its own processes, and returns the results. The
runner does not depend on engines: `start` returns an `Executor`.
"""

import ctypes
import multiprocessing
import os
import pkgutil
import signal
import sys
import threading
from collections.abc import Callable, Hashable
from importlib import import_module
from types import TracebackType
from typing import Any, Generic, NamedTuple, Protocol, Self, TypeVar

from teachers.spec import check_range, unknown

T = TypeVar("T", bound=Hashable)
R = TypeVar("R")
AHEAD = 3
"""Tasks in progress per worker: enough to keep processes busy, few to lose."""
MOST_WORKERS = 4096
NAMES = tuple(sorted({module.name for module in pkgutil.iter_modules(__path__)} - {"batches"}))
"""Names of all executors."""
HERE = frozenset({"here", "threads"})
"""Executors that play in this process, so that definitions in a notebook or a program are available."""

_PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
SPOILED = 77
"""Exit status of a process that an earlier task has spoiled; another process plays its task."""


class Work(NamedTuple, Generic[T, R]):
    """The work of an engine in each of its processes. All fields must be picklable."""

    begin: Callable[[], object]
    """Called first, once per process."""
    call: Callable[[T], R]
    """Called with each task; must not raise."""
    tasks: int
    """Number of tasks."""
    seconds: float | None = None
    """Seconds after which the process of a call is killed."""


class Process:
    """State of this process."""

    owned = False
    """Whether it belongs to an engine, and may be ended."""
    spoiled = False
    """Whether a task was interrupted or may hold much memory, so that the next task needs another process."""

    @classmethod
    def replace(cls) -> None:
        """End this process, so that the engine plays its task in a new one."""
        if cls.owned:
            os._exit(SPOILED)


def end_with_parent() -> None:
    """Have this process end with the one that started it, even if that is killed.

    On Linux the kernel ends it, whatever it does; elsewhere a thread, which cannot while a loop in C keeps others from
    running.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


class Lost(NamedTuple):
    """Result of a task whose process ended."""

    reason: str
    """`time`, `memory` or `died`."""
    error: str


class Executor(Protocol[T, R]):
    """Takes tasks by `submit` and returns results by `wait`, in any order. Leaving the context kills all processes."""

    @property
    def room(self) -> int:
        """Number of tasks in progress that keeps all workers busy."""

    def submit(self, task: T) -> None:
        """Take a task."""

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        """Results since the last call; waits at most `seconds` for the first. None: the task was dropped."""

    def cancel(self) -> list[T]:
        """Drop the tasks that have not begun, or all tasks if that is unknown.

        Returns:
            The dropped tasks, except those that `wait` will return.
        """

    def __enter__(self) -> Self:
        """The engine itself."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Kill all processes, within seconds."""


class ExecutorError(RuntimeError):
    """An engine cannot work, for a reason apart from its tasks."""


def start(name: str, work: Work[T, R], workers: int | None = None, address: str | None = None) -> Executor[T, R]:
    """Start an executor.

    Args:
        name: one of `NAMES`.
        work: the work.
        workers: greatest number of tasks at once, at most `MOST_WORKERS`; None: one per core.
        address: the address of the cluster, for executors with a cluster.

    Raises:
        ValueError: an unknown name, or an argument that the executor does not take.
        ModuleNotFoundError: it needs a package that is not installed; the message says which.
    """
    if workers is not None:
        check_range("workers", workers, 1, MOST_WORKERS, int)
    if name not in NAMES:
        raise ValueError(unknown("executor", name, NAMES))
    module: Any = import_module(f"{__name__}.{name}")
    executor: Executor[T, R] = module.start(work, workers, address)
    return executor
