"""`here`: this process plays the tasks, one after the other.

It can play everything, including functions and classes of a notebook. It cannot kill anything: an agent that ends its
process ends the study. Environment variables and global generators are restored at the end.
"""

import os
import random
from collections import deque
from types import TracebackType
from typing import Generic, Self

import numpy as np

from llf_teacher.studies.execution.executors import Executor, Lost, R, T, Work


class _Here(Generic[T, R]):
    room = 1

    def __init__(self, work: Work[T, R]) -> None:
        self._work = work
        self._tasks: deque[T] = deque()

    def submit(self, task: T) -> None:
        self._tasks.append(task)

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        task = self._tasks.popleft()
        return [(task, self._work.call(task))]

    def cancel(self) -> list[T]:
        dropped = list(self._tasks)
        self._tasks.clear()
        return dropped

    def __enter__(self) -> Self:
        self._environment = dict(os.environ)
        self._drawn = random.getstate(), np.random.get_state()  # noqa: NPY002 (which agents of the user's own may use)
        self._work.begin()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.environ.clear()
        os.environ.update(self._environment)
        random.setstate(self._drawn[0])
        np.random.set_state(self._drawn[1])  # noqa: NPY002 (as above)


def start(work: Work[T, R], workers: int | None, address: str | None) -> Executor[T, R]:
    """See `executors.start`.

    Raises:
        ValueError: more than one worker, or an address.
    """
    if workers not in (None, 1) or address is not None:
        raise ValueError(
            f"the executor 'here' has one worker and no address, got workers={workers} and address={address!r}"
        )
    return _Here(work)
