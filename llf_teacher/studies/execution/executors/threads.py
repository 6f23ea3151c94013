"""`threads`: many tasks at once in this process, for students that wait for a network.

They can play functions of a notebook. Threads cannot be killed, so that there are no limits of time; draws of an agent
from Python's or NumPy's global generator differ from run to run.
"""

import os
import queue
import threading
from types import TracebackType
from typing import Generic, Self

from llf_teacher.studies.execution.executors import AHEAD, Executor, Lost, R, T, Work

_MANY = 64  # default number of threads


class _Threads(Generic[T, R]):
    def __init__(self, work: Work[T, R], workers: int) -> None:
        self._work, self._workers = work, workers
        self.room = workers * AHEAD
        self._tasks: queue.SimpleQueue[T | None] = queue.SimpleQueue()
        self._results: queue.SimpleQueue[tuple[T, R | Lost]] = queue.SimpleQueue()

    def _play(self) -> None:
        while (task := self._tasks.get()) is not None:
            try:
                self._results.put((task, self._work.call(task)))
            except BaseException as error:  # `call` should raise nothing; `wait` must still return the task
                self._results.put((task, Lost("died", f"its thread ended: {error!r}")))

    def submit(self, task: T) -> None:
        self._tasks.put(task)

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        results: list[tuple[T, R | Lost | None]] = []
        try:
            results.append(self._results.get(timeout=seconds))
            while True:
                results.append(self._results.get_nowait())
        except queue.Empty:
            return results

    def cancel(self) -> list[T]:
        dropped: list[T] = []
        try:
            while True:
                if (task := self._tasks.get_nowait()) is not None:
                    dropped.append(task)
        except queue.Empty:
            return dropped

    def __enter__(self) -> Self:
        self._environment = dict(os.environ)
        self._work.begin()
        for number in range(self._workers):  # daemons, since they may wait for a network at the end
            threading.Thread(target=self._play, name=f"llf-player-{number}", daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.cancel()
        for _ in range(self._workers):
            self._tasks.put(None)
        os.environ.clear()
        os.environ.update(self._environment)


def start(work: Work[T, R], workers: int | None, address: str | None) -> Executor[T, R]:
    """See `executors.start`.

    Raises:
        ValueError: an address, or a limit of time.
    """
    if address is not None:
        raise ValueError(f"the executor 'threads' has no address, got address={address!r}")
    if work.seconds is not None:
        raise ValueError("the executor 'threads' cannot enforce limits of time; leave them out, or use 'processes'")
    return _Threads(work, min(workers or _MANY, work.tasks))
