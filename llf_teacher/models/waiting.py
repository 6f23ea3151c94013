"""One event loop per process, in its own thread, which runs the coroutines.

The caller may be in any thread, also in a notebook whose own loop is running.
"""

import asyncio
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
            threading.Thread(target=started.run_forever, name="llf-waiting", daemon=True).start()
        return _loops[os.getpid()]


def wait_for(coroutine: Coroutine[Any, Any, T]) -> T:
    """The result of a coroutine, or its exception; an interrupt cancels the coroutine."""
    future = asyncio.run_coroutine_threadsafe(coroutine, loop())
    try:
        return future.result()
    except BaseException:
        future.cancel()
        raise


def awaited(value: Any) -> Any:
    """The value, or the result of waiting for it if it is what an `async` function gives."""
    return wait_for(_result(value)) if inspect.isawaitable(value) else value


async def _result(awaitable: Awaitable[Any]) -> Any:
    return await awaitable
