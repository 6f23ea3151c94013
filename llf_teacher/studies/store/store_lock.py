"""The lock of a store: only one run writes to it. The operating system releases the lock with its process."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

from llf_teacher.studies.store import StoreError
from llf_teacher.studies.store.files import beside, file_identity

try:
    import fcntl
except ImportError:  # no POSIX: two runs on one store play the same episodes, and each is stored once
    fcntl = None  # type: ignore[assignment]


@contextlib.contextmanager
def lock_store(store: Path) -> Iterator[None]:
    """Lock a store.

    Raises:
        StoreError: another run has locked it.
    """
    if fcntl is None:
        yield
        return
    path = beside(store, "-lock")
    with contextlib.ExitStack() as held:
        while True:
            file = held.enter_context(path.open("wb"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise StoreError(
                    f"another run writes to {store}; wait for it, or give another file by --store and merge both by "
                    "`llf study merge`"
                ) from None
            if file_identity(path) == file_identity(file.fileno()):
                break  # else the holder has just deleted the file: lock the new one
        held.callback(path.unlink, missing_ok=True)
        yield
