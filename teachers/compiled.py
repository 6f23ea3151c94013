"""Functions of numbers: compiled by numba where it is installed (the extra `fast`), elsewhere plain Python."""

import hashlib
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

__all__ = ["COMPILED", "compiled"]

_Function = TypeVar("_Function", bound=Callable[..., Any])

COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
"""Whether functions are compiled: if numba is there, and its own switch, the environment variable `NUMBA_DISABLE_JIT`,
does not say no."""
if COMPILED:
    try:
        import numba
    except ImportError:  # or it does not know this version of NumPy yet
        COMPILED = False


def compiled(function: _Function) -> _Function:
    """Compile a function when it is first called with arguments of these types, where that can be done.

    It may use what numba knows of Python, and call compiled functions of its own folder alone: machine code is kept
    between processes for as long as nothing in that folder changes. Results are equal to the last bit, but for
    `math.hypot`, which numba has another formula for.
    """
    if not COMPILED:
        return function
    given = numba.config.CACHE_DIR
    kept = _kept(Path(function.__code__.co_filename).parent, given)
    try:
        kept.mkdir(parents=True, exist_ok=True)
    except OSError:
        return cast("_Function", numba.njit(function))
    numba.config.CACHE_DIR = str(kept)
    try:
        return cast("_Function", numba.njit(cache=True)(function))
    finally:
        numba.config.CACHE_DIR = given


@lru_cache
def _kept(folder: Path, given: str) -> Path:
    """Where machine code of a folder is kept, as it is now: numba by itself looks at one file only."""
    sources = b"".join([path.read_bytes() for path in sorted(folder.glob("*.py"))])
    name = f"compiled-{hashlib.sha256(sources).hexdigest()[:16]}"
    return Path(given or folder / "__pycache__") / name
