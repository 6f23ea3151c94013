"""One run a store: whoever plays into it holds a lock beside it, which goes with its holder, however that ends."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

from llf_teacher.studies.store import StoreError
from llf_teacher.studies.store.database import place

try:
    import fcntl
except ImportError:  # no POSIX: two runs on one store play the same, and each episode is stored once
    fcntl = None  # type: ignore[assignment]


@contextlib.contextmanager
def lock_store(store: Path) -> Iterator[None]:
    """Hold a store for oneself.

    Raises:
        StoreError: another run has it.
    """
    if fcntl is None:
        yield
        return
    path = store.with_name(f"{store.name}-lock")
    with contextlib.ExitStack() as held:
        while True:
            file = held.enter_context(path.open("wb"))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise StoreError(
                    f"another run plays into {store}; wait for it, or give another file by --store and put both "
                    "together by `llf study merge`"
                ) from None
            if place(path) == place(file.fileno()):
                break  # else its holder has just removed the file: lock the one that is there now
        held.callback(path.unlink, missing_ok=True)
        yield
