"""`ray`: the machines of a Ray cluster. Tasks of a lost worker or node are played again elsewhere."""

import faulthandler
import os
import re
import signal
import socket
from types import TracebackType
from typing import Any, Generic, Self

from llf_teacher.studies.execution.executors import AHEAD, Executor, Lost, Process, R, T, Work
from llf_teacher.studies.execution.executors.batches import Batches, in_batches
from worlds.extras import pip_install

try:
    import ray
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(f"the executor 'ray' needs Ray; run: {pip_install('ray')}") from missing

_RETRIES = 3  # how often a task is played again after the loss of its process or node
_ANSWER = 15.0  # greatest number of seconds for a cluster's answer


def _call(work: Work[T, R], task: T) -> R:
    """Play a task, in a process of Ray."""
    if not Process.owned:
        Process.owned = True
        work.begin()
    if work.seconds is not None:
        faulthandler.dump_traceback_later(work.seconds, exit=True)
    try:
        return work.call(task)
    finally:
        faulthandler.cancel_dump_traceback_later()


def _reach(address: str) -> None:
    """Check that a cluster answers; Ray itself tries for minutes, and then ends the process.

    Raises:
        ConnectionError: nothing answers.
    """
    if not (at := re.fullmatch(r"(?:ray://)?\[?(.+?)\]?:(\d+)", address)):
        return  # `auto`, or an address that Ray refuses at once
    try:
        with socket.create_connection((at[1], int(at[2])), _ANSWER):
            pass
    except (OSError, OverflowError) as error:
        raise ConnectionError(
            f"no Ray cluster can be reached at {address}: {error}; expected the address that `ray start --head` "
            "prints, as in 10.0.0.1:6379. Without an address a cluster is started on this machine"
        ) from None


class _Ray(Generic[T, R]):
    def __init__(self, work: Work[T, R], workers: int | None, address: str | None) -> None:
        self._ours = not ray.is_initialized()
        if self._ours:
            if address is not None:
                _reach(address)
            os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
            local = {} if address is not None else {"num_cpus": workers, "include_dashboard": False}
            before = signal.getsignal(signal.SIGTERM)
            ray.init(address=address or "local", log_to_driver=False, **local)
            signal.signal(signal.SIGTERM, before)  # Ray has replaced it
        cores = int(ray.cluster_resources().get("CPU", 1))
        self.room = max(1, min(cores if workers is None else workers, work.tasks)) * AHEAD
        self._work = ray.put(work)
        self._remote: Any = ray.remote(num_cpus=1, max_retries=_RETRIES, scheduling_strategy="SPREAD")(_call)
        self._tasks: dict[Any, T] = {}

    def submit(self, task: T) -> None:
        self._tasks[self._remote.remote(self._work, task)] = task

    def wait(self, seconds: float) -> list[tuple[T, R | Lost | None]]:
        ready, rest = ray.wait(list(self._tasks), timeout=seconds)
        if ready and rest:
            ready += ray.wait(rest, num_returns=len(rest), timeout=0)[0]
        return [(self._tasks.pop(ref), _result(ref)) for ref in ready]

    def cancel(self) -> list[T]:
        """Drop all tasks, since Ray does not say which have begun."""
        dropped = list(self._tasks.values())
        for ref in self._tasks:
            ray.cancel(ref, force=True)
        self._tasks.clear()
        return dropped

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.cancel()
        if self._ours:
            ray.shutdown()


def _result(ref: Any) -> Any:
    try:
        return ray.get(ref)
    except ray.exceptions.OutOfMemoryError:
        return Lost("memory", "its node had no memory left")
    except ray.exceptions.RayError as error:
        return Lost("died", f"its process or node was lost {_RETRIES + 1} times: {type(error).__name__}")


def start(work: Work[T, R], workers: int | None, address: str | None) -> Executor[T, R]:
    """See `executors.start`; without an address, a cluster is started on this machine, and ended with the study.

    Raises:
        ConnectionError: no cluster answers.
    """
    return Batches(_Ray(in_batches(work), workers, address), work.tasks, single=work.seconds is not None)
