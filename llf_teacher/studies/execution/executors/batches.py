"""Short tasks travel together: to send one to a process costs more than some take.

Not an engine, but what engines of processes are wrapped into. A batch that is lost is played again task by task, so
that only the task is lost that took its process with it.
"""

import time
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import Generic, Self

from llf_teacher.studies.execution.executors import Executor, Lost, Process, R, T, Work

_SECONDS = 1.0  # what a batch should take
_MOST = 32  # tasks in a batch
_NEWS = 0.3  # weight of the last batch in the mean time of a task

Batch = tuple[T, ...]
Told = tuple[list[R], float]
"""The results of a batch, and the seconds that they took; after a task that spoiled the process there are no more."""


def _each(call: Callable[[T], R], tasks: Batch[T]) -> Told[R]:
    """Play a batch, in a process of the engine's."""
    if Process.spoiled:
        Process.replace()
    begun = time.perf_counter()
    results: list[R] = []
    for task in tasks:
        results.append(call(task))
        if Process.spoiled:
            break
    return results, time.perf_counter() - begun


def in_batches(work: Work[T, R]) -> Work[Batch[T], Told[R]]:
    """The same work, of an engine that plays batches."""
    return Work(work.begin, partial(_each, work.call), work.tasks, work.seconds)


class Batches(Generic[T, R]):
    """An executor of tasks by an engine of batches.

    Args:
        engine: plays batches.
        tasks: how many there will be; the last ones travel in small company, so that all processes have some.
        single: one task a batch, for those that have a limit of time.
    """

    def __init__(self, engine: Executor[Batch[T], Told[R]], tasks: int, single: bool) -> None:
        self._engine, self._single, self._left = engine, single, tasks
        self._waiting: list[T] = []
        self._mean: float | None = None

    @property
    def _size(self) -> int:
        if self._single or self._mean is None:
            return 1
        return max(1, min(_MOST, int(_SECONDS / max(self._mean, 1e-9)), self._left // self._engine.room))

    @property
    def room(self) -> int:
        """Tasks for all batches that the engine wants."""
        return self._engine.room * self._size

    def submit(self, task: T) -> None:
        """Send a task as soon as there is a batch, or somebody waits."""
        self._waiting.append(task)
        self._left -= 1
        if len(self._waiting) >= self._size:
            self._send()

    def _send(self) -> None:
        if self._waiting:
            self._engine.submit(tuple(self._waiting))
            self._waiting.clear()

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        """What has come of tasks."""
        self._send()
        ended: list[tuple[T, R | Lost | None]] = []
        for tasks, told in self._engine.wait(seconds):
            if told is None:
                ended += [(task, None) for task in tasks]
                continue
            if isinstance(told, Lost):
                if len(tasks) == 1:
                    ended.append((tasks[0], told))
                    continue
                rest = tasks
            else:
                results, took = told
                mean = took / len(results)
                self._mean = mean if self._mean is None else self._mean + _NEWS * (mean - self._mean)
                ended += zip(tasks, results, strict=False)
                rest = tasks[len(results) :]
            for task in rest:
                self._engine.submit((task,))
        return ended

    def cancel(self) -> list[T]:
        """Drop what has not begun."""
        dropped = [*self._waiting, *(task for tasks in self._engine.cancel() for task in tasks)]
        self._waiting.clear()
        return dropped

    def __enter__(self) -> Self:
        self._engine.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._engine.__exit__(kind, error, trace)
