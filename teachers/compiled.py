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
"""Whether functions are compiled: numba can be imported, and `NUMBA_DISABLE_JIT` does not disable it."""
if COMPILED:
    try:
        import numba
    except ImportError:  # or numba does not support this version of NumPy
        COMPILED = False


def compiled(function: _Function) -> _Function:
    """Compile a function at the first call with arguments of these types, where numba is installed.

    The function may use the part of Python that numba supports, and call compiled functions of its own folder only:
    machine code is cached between processes until a file of that folder changes. Results are equal to the last bit,
    except for those of `math.hypot`, for which numba has another formula.
    """
    if not COMPILED:
        return function
    given = numba.config.CACHE_DIR
    cache = _cache_folder(Path(function.__code__.co_filename).parent, given)
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError:
        return cast("_Function", numba.njit(function))
    numba.config.CACHE_DIR = str(cache)
    try:
        return cast("_Function", numba.njit(cache=True)(function))
    finally:
        numba.config.CACHE_DIR = given


@lru_cache
def _cache_folder(folder: Path, given: str) -> Path:
    """The cache for a folder's present sources; numba's own cache depends on one file only."""
    sources = b"".join([path.read_bytes() for path in sorted(folder.glob("*.py"))])
    name = f"compiled-{hashlib.sha256(sources).hexdigest()[:16]}"
    return Path(given or folder / "__pycache__") / name
