"""Functions of numbers: compiled by numba where it is installed (the extra `fast`), elsewhere plain Python."""

import hashlib
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

from teachers.terminal import Waiting

__all__ = ["COMPILED", "compiled"]

_Function = TypeVar("_Function", bound=Callable[..., Any])

COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
"""Whether functions are compiled: numba is installed, and its variable `NUMBA_DISABLE_JIT` is unset or 0."""
if COMPILED:
    try:
        import numba
        from numba.core import event
    except ImportError:  # or it does not know this version of NumPy yet
        COMPILED = False
    else:

        class _Progress(event.Listener):  # type: ignore[misc]  # numba has no types
            """Says what is compiled: on a terminal each function, elsewhere one line in a process."""

            count = depth = 0
            waiting = Waiting()

            def on_start(self, event: Any) -> None:
                if not hasattr(function := event.data["dispatcher"], "folders"):  # not one of ours
                    return
                what = f"Compiling {function.__module__} with numba; later processes load it"
                if not self.count and not sys.stderr.isatty():
                    sys.stderr.write(f"{what}\n")
                if not self.depth:
                    self.waiting.__enter__()
                self.count, self.depth = self.count + 1, self.depth + 1
                self.waiting.say(f"{what} (function {self.count}, {function.__name__})")

            def on_end(self, event: Any) -> None:
                self.depth -= hasattr(event.data["dispatcher"], "folders")
                if not self.depth:
                    self.waiting.__exit__(None, None, None)

        event.register("numba:compile", _Progress())


def compiled(function: _Function) -> _Function:
    """Compile a function when it is first called with arguments of these types, where that can be done.

    It may use what numba supports of Python, and call compiled functions that are names of its module: machine code is
    kept between processes for as long as nothing changes in the folder of its module, nor in theirs. Results are equal
    to the last bit, except for `math.hypot`, which numba computes by another formula.
    """
    if not COMPILED:
        return function
    given = numba.config.CACHE_DIR
    folders = _folders(function)
    cache = _cache_folder(folders, given)
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError:
        made = numba.njit(function)
    else:
        numba.config.CACHE_DIR = str(cache)
        try:
            made = numba.njit(cache=True)(function)
        finally:
            numba.config.CACHE_DIR = given
    made.folders = folders
    return cast("_Function", made)


def _folders(function: Callable[..., Any]) -> tuple[Path, ...]:
    """The folder of a function's module, then those of the compiled functions that are names of the module."""
    names = [each for each in function.__globals__.values() if isinstance(each, numba.core.dispatcher.Dispatcher)]
    others = {folder for each in names for folder in each.folders}
    own = Path(function.__code__.co_filename).parent
    return own, *sorted(others - {own})


@lru_cache
def _cache_folder(folders: tuple[Path, ...], given: str) -> Path:
    """Where machine code is kept that depends on the sources in these folders: numba by itself checks one file only."""
    sources = b"".join([path.read_bytes() for folder in folders for path in sorted(folder.glob("*.py"))])
    name = f"compiled-{hashlib.sha256(sources).hexdigest()[:16]}"
    return Path(given or folders[0] / "__pycache__") / name
