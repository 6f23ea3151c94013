"""Opening the file of a store, and finding its log.

While a process writes to a store, it is in SQLite's write-ahead mode: the newest episodes are in a log beside the file.
When the last writer closes it, they move into the file, which leaves that mode. So a file in that mode without a log is
a copy that lacks the newest episodes.
"""

import contextlib
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path

_MODE, _LOGGED = slice(18, 20), b"\2\2"  # bytes of the header, https://www.sqlite.org/fileformat.html


def log_of(path: Path) -> Path:
    """The path of SQLite's log of a file."""
    return path.with_name(f"{path.name}-wal")


def has_lost_its_log(path: Path) -> bool:
    """Whether a file is half of a store: the log with its newest episodes is missing."""
    with path.open("rb") as file:
        return file.read(_MODE.stop)[_MODE] == _LOGGED and not log_of(path).exists()


def connect(path: Path, *, read_only: bool = False) -> sqlite3.Connection:
    """A connection that any thread may use and close, without transactions of its own.

    Args:
        path: the file; it is created if it does not exist, except with `read_only`.
        read_only: whether nothing can be written; then the folder may be read-only.

    Raises:
        sqlite3.Error: it cannot be opened.
    """
    if not read_only:
        return sqlite3.connect(path, isolation_level=None, check_same_thread=False)
    log, index = log_of(path), path.with_name(f"{path.name}-shm")
    if log.exists() and not index.exists() and not os.access(log.parent, os.W_OK):
        raise sqlite3.OperationalError(
            f"its newest episodes are in {log.name}, which can only be read in a folder that can be written to; copy "
            "both files to one"
        )
    # SQLite would make a log for a file in write-ahead mode; without a log nobody writes to it.
    mode = "mode=ro&immutable=1" if has_lost_its_log(path) else "mode=ro"
    return sqlite3.connect(
        f"{path.absolute().as_uri()}?{mode}", uri=True, isolation_level=None, check_same_thread=False
    )


@contextlib.contextmanager
def reading(path: Path) -> Iterator[sqlite3.Connection]:
    """A context with a read-only connection."""
    with contextlib.closing(connect(path, read_only=True)) as db:
        yield db


def begin_writing(db: sqlite3.Connection) -> None:
    """Write to the log first, so that others can read at the same time."""
    db.execute("PRAGMA journal_mode = WAL")
    db.execute("PRAGMA synchronous = NORMAL")


def close(db: sqlite3.Connection) -> None:
    """Close a connection; the last one that can write empties the log into the file."""
    with contextlib.suppress(sqlite3.Error):  # it is open elsewhere, read-only or damaged, or the disk is full
        db.execute("PRAGMA busy_timeout = 0")
        db.execute("PRAGMA journal_mode = DELETE")
    db.close()


def file_identity(path: Path | int) -> tuple[int, int] | None:
    """Device and inode of the file at a path, or of an open file by its number; None if there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino
