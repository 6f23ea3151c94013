"""One event loop per process, in its own thread, which runs the coroutines.

The caller may be in any thread, also in a notebook whose own loop is running.
"""

import asyncio
import contextlib
import inspect
import os
import threading
from collections.abc import Awaitable, Coroutine
from typing import Any, TypeVar

T = TypeVar("T")

_lock = threading.Lock()
_loops: dict[int, asyncio.AbstractEventLoop] = {}  # by process: a fork inherits the loop, but not its thread


def loop() -> asyncio.AbstractEventLoop:
    """The loop of this process."""
    with _lock:
        if os.getpid() not in _loops:
            _loops[os.getpid()] = started = asyncio.new_event_loop()
            threading.Thread(target=_run, args=(started,), name="llf-waiting", daemon=True).start()
        return _loops[os.getpid()]


def _run(loop: asyncio.AbstractEventLoop) -> None:
    while True:  # a coroutine that exits or stops the loop does not end other coroutines
        with contextlib.suppress(SystemExit, KeyboardInterrupt):
            loop.run_forever()


def wait_for(coroutine: Coroutine[Any, Any, T]) -> T:
    """The result of a coroutine, or its exception; an interrupt cancels the coroutine.

    Raises:
        RuntimeError: the coroutine raised SystemExit or KeyboardInterrupt, which would end this process.
    """
    future = asyncio.run_coroutine_threadsafe(coroutine, loop())
    try:
        return future.result()
    except BaseException as error:
        if not future.cancel() and isinstance(error, SystemExit | KeyboardInterrupt):
            raise RuntimeError(f"a coroutine must not end the process, got {error!r}; raise another error") from error
        raise


def awaited(value: Any) -> Any:
    """The value, or its result if it is a coroutine."""
    return wait_for(_result(value)) if inspect.isawaitable(value) else value


async def _result(awaitable: Awaitable[Any]) -> Any:
    return await awaitable
