"""Opening the file of a store, and finding its log.

While a process writes to a store, it is in SQLite's write-ahead mode: the newest episodes are in a log beside the file.
When the last writer closes it, they move into the file, which leaves that mode. So a file in that mode without a log is
a copy that lacks the newest episodes, and so is one whose log ends before its last transaction does.
"""

import contextlib
import os
import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path

_MODE, _LOGGED = slice(18, 20), b"\2\2"  # bytes of the header, https://www.sqlite.org/fileformat.html


_LOG, _FRAME = struct.Struct(">8xI4x8s8x"), struct.Struct(">4xI8s8x")  # headers of a log and of a page in it
_INDEX = struct.Struct("=16xI")  # the beginning of a log's index


def log_of(path: Path) -> Path:
    """The path of SQLite's log of a file."""
    return beside(path, "-wal")


def beside(path: Path, ending: str) -> Path:
    """A file beside another one, with its name and an ending; as for SQLite, beside what a link points to."""
    real = path.resolve()
    return real.with_name(f"{real.name}{ending}")


def has_lost_its_log(path: Path) -> bool:
    """Whether a file is half of a store: the log with its newest episodes is missing."""
    with path.open("rb") as file:
        return file.read(_MODE.stop)[_MODE] == _LOGGED and not log_of(path).exists()


def _index_of(path: Path) -> Path:
    return beside(path, "-shm")


def log_is_cut(path: Path) -> bool:
    """Whether the log of a file lacks its end. Ask before the file is opened, which makes a new index of the log.

    The index, which a killed writer leaves, has the number of pages in the log. A copy has none: its log must end with
    a whole transaction.
    """
    log, index = log_of(path), _index_of(path)
    try:
        known = index.exists()
        pages = _INDEX.unpack_from(index.read_bytes().ljust(_INDEX.size, b"\0"))[0] if known else 0
        with log.open("rb") as file:
            (size, salt), length = _LOG.unpack(file.read(_LOG.size).ljust(_LOG.size, b"\0")), log.stat().st_size
            if known:  # a writer may be at work, and the log does not shrink
                return pages > 0 and length < _LOG.size + pages * (_FRAME.size + size)
            last = 1
            for at in range(_LOG.size, length, _FRAME.size + size):
                file.seek(at)
                ends, of = _FRAME.unpack(file.read(_FRAME.size).ljust(_FRAME.size, b"\0"))
                last = ends if of == salt else last  # what follows the newest transaction is of an earlier round
    except FileNotFoundError:
        return False
    whole = size > 0 and (length - _LOG.size) % (_FRAME.size + size) == 0 and last > 0
    return not whole and not index.exists()


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
    log, index = log_of(path), _index_of(path)
    if log.exists() and not index.exists() and not os.access(log.parent, os.W_OK):
        raise sqlite3.OperationalError(
            f"its newest episodes are in {log.name}, which can only be read in a folder that can be written to; copy "
            "both files to one"
        )
    # SQLite would make a log for a file in write-ahead mode, or a new index; without a whole log nobody writes to it.
    mode = "mode=ro&immutable=1" if has_lost_its_log(path) or log_is_cut(path) else "mode=ro"
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
    with contextlib.suppress(sqlite3.Error, UnicodeDecodeError):  # open elsewhere, read-only, damaged, or a full disk
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
