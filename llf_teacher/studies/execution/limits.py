"""Limits of time and memory, enforced in the process that plays."""

import contextlib
import signal
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import NamedTuple

try:
    import resource
except ImportError:  # no POSIX
    resource = None  # type: ignore[assignment]

_GRACE = 10.0  # seconds beyond a limit before a process with an unfinished episode is killed
_MEGABYTE = 1 << 20


class TimeIsUp(KeyboardInterrupt):
    """A limit of time is reached. It interrupts like Ctrl-C, since agents may catch every `Exception`."""


class Limits(NamedTuple):
    """Limits of an episode; None: no limit."""

    episode_seconds: float | None = None
    turn_seconds: float | None = None
    """Seconds from one answer of the environment to the next."""
    memory: int | None = None
    """Megabytes of data of the process that plays, as Linux counts them: interpreter and libraries take some 300."""

    def check(self) -> None:
        """Check that the limits can be enforced here.

        Raises:
            ValueError: a limit is not above 0, or this is no POSIX system.
        """
        for name, value in self._asdict().items():
            if value is not None and not value > 0:
                raise ValueError(f"{name} must be above 0, got {value!r}")
        if any(value is not None for value in self) and (resource is None or not hasattr(signal, "setitimer")):
            raise ValueError("limits of time and memory need a POSIX system; leave them out")

    def hard_seconds(self, turns: int) -> float | None:
        """Seconds until the process of an episode with this number of turns is killed; None without limits."""
        each = None if self.turn_seconds is None else self.turn_seconds * (turns + 1)
        longest = [seconds for seconds in (self.episode_seconds, each) if seconds is not None]
        return min(longest) + _GRACE if longest else None


class Clock:
    """Raises `TimeIsUp` in the main thread of this process when an episode or a turn takes too long."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._began = time.monotonic()
        self._turn = 0
        self._kept = limits.episode_seconds is not None or limits.turn_seconds is not None
        if self._kept and threading.current_thread() is not threading.main_thread():
            raise ValueError(
                "limits of time can be enforced in the main thread only; play in processes, or leave them out"
            )

    def turn(self, turn: int) -> None:
        """Start the time of a turn."""
        if not self._kept:
            return
        self._turn = turn
        left = []
        if self._limits.episode_seconds is not None:
            left.append(self._began + self._limits.episode_seconds - time.monotonic())
        if self._limits.turn_seconds is not None and turn:
            left.append(self._limits.turn_seconds)
        # The alarm repeats, since agents may catch what it raises.
        signal.setitimer(signal.ITIMER_REAL, max(min(left), 1e-6) if left else 0, 0.1)

    def _ring(self, signal_number: int, frame: FrameType | None) -> None:
        episode = self._limits.episode_seconds
        if episode is not None and time.monotonic() >= self._began + episode:
            raise TimeIsUp(f"not over after {episode:g} seconds, in turn {self._turn}")
        raise TimeIsUp(f"turn {self._turn} was not over after {self._limits.turn_seconds:g} seconds")

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Run the clock; the earlier handler of the alarm is restored at the end."""
        if not self._kept:
            yield
            return
        before = signal.signal(signal.SIGALRM, self._ring)
        try:
            self.turn(0)
            yield
        finally:
            self.stop()
            signal.signal(signal.SIGALRM, before)

    def stop(self) -> None:
        """Stop the clock."""
        signal.setitimer(signal.ITIMER_REAL, 0)


@contextlib.contextmanager
def within_memory(megabytes: int | None) -> Iterator[None]:
    """Limit the memory of this process, so that larger requests raise `MemoryError`."""
    if megabytes is None:
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    most = megabytes * _MEGABYTE
    resource.setrlimit(resource.RLIMIT_DATA, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))
