"""The server's log, in which what repeats has one line a minute."""

import logging
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any

__all__ = ["LOGGING", "Seldom"]


class Seldom(logging.Filter):
    """Passes one record a minute of those that come from the same place; the next one says how many it left out.

    The place is that of the log's call and, with an exception, its type and where it was raised: texts may differ.

    Args:
        seconds: the time in which a record is not repeated.
        clock: a monotonic clock, in seconds.
    """

    def __init__(self, seconds: float = 60.0, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._seconds, self._clock = seconds, clock
        self._passed: dict[
            tuple[Any, ...], tuple[float, int]
        ] = {}  # by the place: when one passed, and how many did not

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is to be logged."""
        place: tuple[Any, ...] = (record.pathname, record.lineno)
        if record.exc_info and record.exc_info[0]:
            place += (record.exc_info[0], *_raised(record.exc_info[2]))
        now = self._clock()
        when, left_out = self._passed.get(place, (-self._seconds, 0))
        if now - when < self._seconds:
            self._passed[place] = when, left_out + 1
            return False
        if left_out:
            record.msg = f"{record.getMessage()} ({left_out} more like this one were not logged)"
            record.args = ()
        self._passed[place] = now, 0
        return True


def _raised(trace: TracebackType | None) -> tuple[str, int]:
    """The file and the line in which an exception was raised."""
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    return ("", 0) if trace is None else (trace.tb_frame.f_code.co_filename, trace.tb_lineno)


LOGGING: dict[str, Any] = {
    "version": 1,
    "disable_existing_loggers": False,
    "filters": {"seldom": {"()": Seldom}},
    "formatters": {"plain": {"format": "%(levelname)s: %(message)s"}},
    "handlers": {"terminal": {"class": "logging.StreamHandler", "formatter": "plain", "filters": ["seldom"]}},
    "loggers": {
        name: {"handlers": ["terminal"], "level": "WARNING", "propagate": False} for name in ("uvicorn", "asyncio")
    },
}
"""The configuration of logging: warnings of the server and of the event loop, on the terminal."""
