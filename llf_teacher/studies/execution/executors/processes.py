"""`processes`: processes of this machine. If one ends, only its own task is lost."""

import ast
import os
import signal
import sys
import time
import tokenize
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.synchronize import Event
from pathlib import Path
from types import FrameType, TracebackType
from typing import Any, Generic, Self

from pebble import ProcessExpired, ProcessPool

from llf_teacher.studies.execution.executors import (
    AHEAD,
    SPOILED,
    Executor,
    ExecutorError,
    Lost,
    Process,
    R,
    T,
    Work,
    end_with_parent,
)
from llf_teacher.studies.execution.executors.batches import Batches, in_batches

_LEFT = 78  # instead of 0: exit status of a worker that ended unexpectedly
_LOOKS = 5  # how often the pool looks for a process that has ended by itself, with all messages read, before it is gone
_BROKEN = 3  # consecutive failures to start a process
_GUARD = 'put what a script does under `if __name__ == "__main__":`, or play in this process by workers=1'


class _Worker(SpawnProcess):
    """A process that plays.

    Args:
        unread: whether messages of processes wait to be read.
    """

    _stopped = False
    _looks = 0

    def __init__(self, unread: Callable[[], bool], *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._unread = unread

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_unread"}  # which is the parent's

    def is_alive(self) -> bool:
        """Whether it runs, or its last message may not have been read.

        The pool looks every 0.1 seconds, and fails the task of a process that is gone. Which task that is, the process
        says when it takes it; if the pool looked for the process before it read that, it would wait for the task for
        ever.
        """
        if super().is_alive() or self.pid is None:
            return super().is_alive()
        self._looks += not self._unread()
        return not self._stopped and self._looks < _LOOKS

    def terminate(self) -> None:
        """End it."""
        self._stopped = True
        super().terminate()

    def kill(self) -> None:
        """End it at once."""
        self._stopped = True
        super().kill()

    def start(self) -> None:
        """Start and ignore Ctrl-C, which the parent handles."""
        if not hasattr(signal, "pthread_sigmask"):
            return super().start()
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            return super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    @property
    def exitcode(self) -> int | None:
        """Never 0, which the pool takes for an intended end."""
        return super().exitcode if super().exitcode != 0 else _LEFT


class _Context(SpawnContext):
    """Spawned processes start from a clean interpreter, the same on every platform."""

    def __init__(self) -> None:
        super().__init__()
        self.processes: list[_Worker] = []
        self.pool: ProcessPool | None = None

    def Process(self, *args: Any, **options: Any) -> _Worker:  # type: ignore[override]  # noqa: N802 (both as there)
        self.processes = [process for process in self.processes if process.is_alive()]
        self.processes.append(_Worker(self._unread, *args, **options))
        return self.processes[-1]

    def _unread(self) -> bool:
        channel = self.pool and self.pool._pool_manager.worker_manager.pool_channel  # pebble has no public way to it
        try:
            return bool(channel and channel.poll(0))
        except OSError:  # the pool has closed it
            return False


def _check_guard() -> None:
    """Check that no script begins processes at its top level: each of them would import, and so run, the script.

    Raises:
        ExecutorError: the script that runs has the call outside of any condition, or is no file.
    """
    main = sys.modules["__main__"]
    if main.__spec__ and main.__spec__.name.endswith("__main__"):
        return  # `python -m package`, which processes do not import
    frame: FrameType | None = sys._getframe()
    while frame and not (frame.f_globals is vars(main) and frame.f_code.co_name == "<module>"):
        frame = frame.f_back
    if frame is None or frame.f_code.co_filename != getattr(main, "__file__", None):
        return  # called by a function elsewhere, in a notebook, or with `python -c`
    if not Path(frame.f_code.co_filename).is_file():
        raise ExecutorError(
            f"the script {frame.f_code.co_filename} is no file, and each of the processes in which it plays would read "
            "it again; write it to a file, or play in this process by workers=1"
        )
    with tokenize.open(frame.f_code.co_filename) as file:
        statements = ast.parse(file.read()).body
    called = [each for each in statements if each.lineno <= frame.f_lineno <= (each.end_lineno or each.lineno)]
    if called and not isinstance(called[0], ast.If):
        raise ExecutorError(
            f"{frame.f_code.co_filename}, line {frame.f_lineno}, plays in other processes, and each of them would run "
            f"the script again; {_GUARD}"
        )


class _Processes(Generic[T, R]):
    def __init__(self, work: Work[T, R], workers: int) -> None:
        self._work, self._workers = work, workers
        self.room = workers * AHEAD
        self._tasks: dict[Future[R | None], T] = {}
        self._running: dict[Future[R | None], float] = {}
        """When each running task was first seen."""
        self._broken = 0
        self._over = _Context().Event()
        self._begin()

    def _begin(self) -> None:
        self._context = _Context()
        given = (self._work.begin, self._over)
        self._pool = ProcessPool(self._workers, initializer=_begin, initargs=given, context=self._context)
        self._context.pool = self._pool

    def submit(self, task: T) -> None:
        self._tasks[self._pool.schedule(partial(_unless_over, self._work.call), args=(task,))] = task

    def _cancel_late(self) -> None:
        """End the tasks that take too long. The pool's own limit is by a clock that may be set."""
        now = time.monotonic()
        self._running = {future: self._running.get(future, now) for future in self._tasks if future.running()}
        for future, begun in self._running.items():
            if self._work.seconds is not None and now - begun > self._work.seconds:
                future.cancel()  # its process is ended

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        results: list[tuple[T, R | Lost | None]] = []
        self._cancel_late()
        for future in wait(self._tasks, seconds, FIRST_COMPLETED).done:
            task = self._tasks.pop(future)
            try:
                results.append((task, future.result()))
                self._broken = 0
            except CancelledError:
                error = f"not over after {self._work.seconds:g} seconds, and did not end by itself"
                results.append((task, Lost("time", error)))
            except ProcessExpired as error:
                if error.exitcode == SPOILED:
                    self.submit(task)
                else:
                    results.append((task, Lost("died", _how(error.exitcode))))
            except BrokenProcessPool as error:
                self._restart([task, *self._tasks.values()], error)
                break
        return results

    def _restart(self, tasks: list[T], error: BrokenProcessPool) -> None:
        """Start new processes for the tasks."""
        self._broken += 1
        self._end()
        if self._broken == _BROKEN:
            raise ExecutorError(f"worker processes end as soon as they start: {error}; {_GUARD}") from None
        self._tasks.clear()
        self._begin()
        for task in tasks:
            self.submit(task)

    def cancel(self) -> list[T]:
        """Have the processes drop tasks; a future's `cancel` could interrupt a running one."""
        self._over.set()
        return []

    def _end(self) -> None:
        self._pool.stop()  # type: ignore[no-untyped-call]  # some of the package's functions have no types
        for process in self._context.processes:
            if process.is_alive():  # pool.stop would do it one by one, after seconds each
                process.kill()
        self._pool.join()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end()


_over: Event
"""In a worker: set if no more tasks should begin."""


def _unless_over(call: Callable[[T], R], task: T) -> R | None:
    """Play a task, in a worker."""
    return None if _over.is_set() else call(task)


def _begin(begin: Callable[[], object], over: Event) -> None:
    """Set up a worker, which ends with its parent, even if the parent is killed."""
    global _over
    _over = over
    Process.owned = True
    end_with_parent()
    begin()


def _how(code: int) -> str:
    """The end of a process, as text."""
    if code < 0:
        try:
            return f"its process was ended by {signal.Signals(-code).name}"
        except ValueError:
            pass
    return f"its process ended with exit status {0 if code == _LEFT else code}"


def start(work: Work[T, R], workers: int | None, address: str | None) -> Executor[T, R]:
    """See `executors.start`.

    Raises:
        ValueError: an address.
        ExecutorError: see `_check_guard`.
    """
    if address is not None:
        raise ValueError(f"the executor 'processes' has no address, got address={address!r}")
    _check_guard()
    engine = _Processes(in_batches(work), min(workers or os.cpu_count() or 1, work.tasks))
    return Batches(engine, work.tasks, single=work.seconds is not None)
