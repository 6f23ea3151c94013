"""Answers on disk, with a ledger of what they cost, shared by all processes: nothing is paid for twice."""

import contextlib
import hashlib
import json
import sqlite3
import time
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

try:
    import fcntl
except ImportError:  # no POSIX: two processes may ask the same thing at the same moment
    fcntl = None  # type: ignore[assignment]

MEMORY = ":memory:"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS answer (key TEXT PRIMARY KEY, request TEXT NOT NULL, text TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS ledger (id INTEGER PRIMARY KEY, time REAL NOT NULL, key TEXT NOT NULL, model TEXT NOT NULL,
    input_tokens INTEGER, output_tokens INTEGER, usd REAL);
"""


class Usage(NamedTuple):
    """What an answer cost."""

    input_tokens: int | None
    """None if the endpoint does not say; so with `output_tokens`."""
    output_tokens: int | None
    usd: float | None
    """None if the tokens or the prices are unknown."""


class Cache:
    """Answers by the whole of what was asked.

    Args:
        path: the SQLite file, made if there is none; `:memory:` for none.

    Raises:
        ValueError: the file cannot be used.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        try:
            # A cache that nobody uses any more may be collected, and closed, in any thread.
            self._db = sqlite3.connect(path, timeout=60, isolation_level=None, check_same_thread=False)
            weakref.finalize(self, self._db.close)
            self._db.execute("PRAGMA journal_mode = WAL")
            self._db.execute("PRAGMA synchronous = FULL")  # a paid answer outlasts even the computer
            self._db.executescript(_SCHEMA)
        except sqlite3.DatabaseError as error:
            raise ValueError(f"cannot keep answers of language models in {path}: {error}; set LLF_LLM_CACHE") from None

    @staticmethod
    def key(request: dict[str, Any]) -> str:
        """The digest of a request."""
        return hashlib.sha256(json.dumps(request, sort_keys=True).encode()).hexdigest()

    def get(self, key: str) -> str | None:
        """The answer that is there, if any."""
        row: tuple[str] | None = self._db.execute("SELECT text FROM answer WHERE key = ?", (key,)).fetchone()
        return row[0] if row else None

    def add(self, key: str, request: dict[str, Any], text: str | None, usage: Usage) -> None:
        """Enter a reply into the ledger and, unless it had no answer, into the cache; both or neither."""
        with contextlib.closing(self._db.cursor()) as cursor:
            cursor.execute("BEGIN IMMEDIATE")
            try:
                row = (time.time(), key, request["model"], *usage)
                cursor.execute(
                    "INSERT INTO ledger (time, key, model, input_tokens, output_tokens, usd) VALUES (?, ?, ?, ?, ?, ?)",
                    row,
                )
                if text is not None:
                    asked = json.dumps(request, ensure_ascii=False)
                    cursor.execute("INSERT OR IGNORE INTO answer VALUES (?, ?, ?)", (key, asked, text))
                cursor.execute("COMMIT")
            except BaseException:
                cursor.execute("ROLLBACK")
                raise

    def spent(self) -> float:
        """USD in the ledger."""
        row: tuple[float] = self._db.execute("SELECT total(usd) FROM ledger").fetchone()
        return row[0]

    def by_model(self) -> list[dict[str, Any]]:
        """The ledger summed up: per model the number of replies, their tokens and their price in USD."""
        names = ("model", "requests", "input_tokens", "output_tokens", "usd")
        sums = "count(*), coalesce(sum(input_tokens), 0), coalesce(sum(output_tokens), 0), total(usd)"
        rows = self._db.execute(f"SELECT model, {sums} FROM ledger GROUP BY model ORDER BY model")  # noqa: S608
        return [dict(zip(names, row, strict=True)) for row in rows]

    @contextlib.contextmanager
    def alone(self, key: str) -> Iterator[None]:
        """Hold a request for oneself, so that others who would ask the same wait for its answer."""
        if fcntl is None or self.path == MEMORY:
            yield
            return
        with open(f"{self.path}-lock", "ab") as file:  # the lock goes with its holder, however that ends
            fcntl.lockf(file, fcntl.LOCK_EX, 1, int(key[:15], 16))
            yield

    def close(self) -> None:
        """Close the file."""
        self._db.close()


def spending(path: str) -> list[dict[str, Any]]:
    """`Cache.by_model` of a file; empty if there is none."""
    if path == MEMORY or not Path(path).exists():
        return []
    with contextlib.closing(Cache(path)) as cache:
        return cache.by_model()
