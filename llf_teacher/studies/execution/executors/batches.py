"""Batches of short tasks, since sending a task to a process may cost more than playing it.

This is no engine, but a wrapper of engines with processes. A lost batch is played again task by task, so that only the
task that ended its process is lost.
"""

import time
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import Generic, Self

from llf_teacher.studies.execution.executors import Executor, Lost, Process, R, T, Work

_SECONDS = 1.0  # desired duration of a batch
_MOST = 32  # greatest number of tasks in a batch
_NEWS = 0.3  # weight of the last batch in the mean time of a task

Batch = tuple[T, ...]
BatchResult = tuple[list[R], float]
"""The results of a batch, up to a task that spoiled the process, and their duration in seconds."""


def _each(call: Callable[[T], R], tasks: Batch[T]) -> BatchResult[R]:
    """Play a batch, in a process of the engine."""
    if Process.spoiled:
        Process.replace()
    begun = time.perf_counter()
    results: list[R] = []
    for task in tasks:
        results.append(call(task))
        if Process.spoiled:
            break
    return results, time.perf_counter() - begun


def in_batches(work: Work[T, R]) -> Work[Batch[T], BatchResult[R]]:
    """The same work for an engine that plays batches."""
    return Work(work.begin, partial(_each, work.call), work.tasks, work.seconds)


class Batches(Generic[T, R]):
    """An executor of tasks on top of an engine for batches.

    Args:
        engine: plays batches.
        tasks: their number; the last batches are small, so that all processes are busy.
        single: whether each batch has one task, for tasks with a limit of time.
    """

    def __init__(self, engine: Executor[Batch[T], BatchResult[R]], tasks: int, single: bool) -> None:
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
        """Number of tasks in all batches that the engine should have in progress."""
        return self._engine.room * self._size

    def submit(self, task: T) -> None:
        """Take a task; it is sent with a full batch, or at the next `wait`."""
        self._waiting.append(task)
        self._left -= 1
        if len(self._waiting) >= self._size:
            self._send()

    def _send(self) -> None:
        if self._waiting:
            self._engine.submit(tuple(self._waiting))
            self._waiting.clear()

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        """Results of tasks."""
        self._send()
        ended: list[tuple[T, R | Lost | None]] = []
        for tasks, result in self._engine.wait(seconds):
            if result is None:
                ended += [(task, None) for task in tasks]
                continue
            if isinstance(result, Lost):
                if len(tasks) == 1:
                    ended.append((tasks[0], result))
                    continue
                rest = tasks
            else:
                results, took = result
                mean = took / len(results)
                self._mean = mean if self._mean is None else self._mean + _NEWS * (mean - self._mean)
                ended += zip(tasks, results, strict=False)
                rest = tasks[len(results) :]
            for task in rest:
                self._engine.submit((task,))
        return ended

    def cancel(self) -> list[T]:
        """Drop the tasks that have not begun."""
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
