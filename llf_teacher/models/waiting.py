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


class WaitsForItselfError(RuntimeError):
    """A coroutine called a function that waits for the loop in which it runs."""

    lost = False
    """Whether an endpoint may have charged for a request: it was not sent."""


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
        WaitsForItselfError: the caller runs in the loop, so that it would wait for itself for ever.
    """
    _check_apart(coroutine)
    future = asyncio.run_coroutine_threadsafe(coroutine, loop())
    try:
        return future.result()
    except BaseException as error:
        own = not future.cancel() and future.exception() is error  # else an interrupt came as the coroutine ended
        if own and isinstance(error, SystemExit | KeyboardInterrupt):
            raise RuntimeError(f"a coroutine must not end the process, got {error!r}; raise another error") from error
        raise


def _check_apart(*values: Any) -> None:
    """Check that the caller does not run in the loop; if it does, the coroutines among the values are closed."""
    if asyncio._get_running_loop() is loop():
        for value in values:
            if inspect.iscoroutine(value):
                value.close()
        raise WaitsForItselfError(
            "a coroutine that llf_teacher awaits called a function that waits, and would wait for itself for ever; "
            "call it in a thread: await asyncio.to_thread(function, ...)"
        )


def awaited(value: Any) -> Any:
    """The value, or its result if it is a coroutine."""
    if not inspect.isawaitable(value):
        return value
    _check_apart(value)
    return wait_for(_result(value))


def all_awaited(values: list[Any]) -> list[Any]:
    """The values, each coroutine among them replaced by its result, or by the exception that it raises."""
    if not any(map(inspect.isawaitable, values)):
        return values
    _check_apart(*values)
    return wait_for(_results(values))


async def _result(awaitable: Awaitable[Any]) -> Any:
    return await awaitable


async def _results(values: list[Any]) -> list[Any]:
    awaitable = [value for value in values if inspect.isawaitable(value)]
    results = iter(await asyncio.gather(*awaitable, return_exceptions=True))
    return [next(results) if inspect.isawaitable(value) else value for value in values]
