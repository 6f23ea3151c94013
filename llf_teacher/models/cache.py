"""A cache of answers on disk with a ledger of costs, shared by all processes, so that no request is paid twice."""

import contextlib
import hashlib
import json
import os
import socket
import sqlite3
import threading
import time
import weakref
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from llf_teacher.models.forms import AnswerForm
from llf_teacher.models.images import without_images
from llf_teacher.models.replies import Answer, Usage

try:
    import fcntl
except ImportError:  # not POSIX: two processes may send the same request at the same time
    fcntl = None  # type: ignore[assignment]

MEMORY = ":memory:"
_SCHEMA = """
CREATE TABLE IF NOT EXISTS answer (key TEXT PRIMARY KEY, request TEXT NOT NULL, text TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS ledger (id INTEGER PRIMARY KEY, time REAL NOT NULL, key TEXT NOT NULL, model TEXT NOT NULL,
    input_tokens INTEGER, output_tokens INTEGER, usd REAL);
DROP TABLE IF EXISTS pledge;
CREATE TABLE IF NOT EXISTS under_way (id INTEGER PRIMARY KEY, until REAL NOT NULL, usd REAL, host TEXT NOT NULL,
    process INTEGER NOT NULL, key TEXT NOT NULL, model TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS sent (model TEXT PRIMARY KEY, requests INTEGER NOT NULL, lost INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS served (endpoint TEXT, model TEXT, id TEXT NOT NULL, PRIMARY KEY (endpoint, model));
CREATE TABLE IF NOT EXISTS form (key TEXT PRIMARY KEY, model TEXT NOT NULL, name TEXT NOT NULL, why TEXT NOT NULL)
    WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS trial (key TEXT PRIMARY KEY) WITHOUT ROWID;
"""
_FORMS = "SELECT model, name, why FROM form ORDER BY key"
_TRIES = 100  # attempts to set the mode of a file, 0.1 s apart
_FACTS = ("reasoning", "finish", "model", "seconds", "call", "unsent")


@dataclass
class Sent:
    """The requests sent for an answer."""

    requests: int = 0
    """Number of requests."""
    lost: int = 0
    """Number of requests without a reply; the endpoint may charge for them."""


class Cache:
    """Answers by their requests. Many threads may use it.

    Args:
        path: the SQLite file, created if missing; `:memory:` for no file.

    Raises:
        ValueError: the file cannot be used.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._one = threading.RLock()
        self._asking: weakref.WeakValueDictionary[str, Any] = weakref.WeakValueDictionary()
        try:
            # A cache without references may be collected, and closed, in any thread.
            self._db = sqlite3.connect(path, timeout=60, isolation_level=None, check_same_thread=False)
            weakref.finalize(self, self._db.close)
            with contextlib.ExitStack() as on_error:
                on_error.callback(self.close)
                self._prepare()
                on_error.pop_all()
        except sqlite3.DatabaseError as error:
            raise ValueError(f"cannot keep answers of language models in {path}: {error}; set LLF_LLM_CACHE") from None

    def _prepare(self) -> None:
        self._write_ahead()
        self._db.execute("PRAGMA synchronous = FULL")  # a paid answer survives a power failure
        self._db.executescript(_SCHEMA)
        with self._writing() as db:  # files of an earlier release have only the text
            if "facts" not in {row[1] for row in db.execute("PRAGMA table_info(answer)")}:
                db.execute("ALTER TABLE answer ADD COLUMN facts TEXT")

    def _write_ahead(self) -> None:
        """Set the mode, with retries, since SQLite does not wait while another process sets it."""
        for left in reversed(range(_TRIES)):
            try:
                self._db.execute("PRAGMA journal_mode = WAL")
                return
            except sqlite3.OperationalError:
                if not left:
                    raise
                time.sleep(0.1)

    @staticmethod
    def key(request: dict[str, Any]) -> str:
        """The digest of a request."""
        return hashlib.sha256(json.dumps(request, sort_keys=True).encode()).hexdigest()

    def get(self, key: str) -> Answer | None:
        """The answer in the cache; None if there is none."""
        row = self._first("SELECT text, facts FROM answer WHERE key = ?", key)
        if row is None:
            return None
        facts = json.loads(row[1] or "{}")
        usage, unsent = Usage(*facts.pop("usage", ())), tuple(facts.pop("unsent", ()))
        return Answer(row[0], **facts, usage=usage, unsent=unsent)

    def add(
        self,
        key: str,
        request: dict[str, Any],
        answer: Answer | None,
        usage: Usage,
        pledge: int | None,
        sent: Sent = Sent(1),  # noqa: B008 (never changed here)
    ) -> None:
        """Enter a reply, or a request without one, into the ledger and its answer into the cache, in one transaction.

        Args:
            key: the key of the request.
            request: the request.
            answer: the answer in the reply; None without one.
            usage: the cost. An unknown cost counts as the pledge, so that the limit holds.
            pledge: number of the pledge that the cost replaces.
            sent: the requests sent for it.
        """
        with self._writing() as db:
            most = db.execute("SELECT usd FROM under_way WHERE id = ?", (pledge,)).fetchone() or (None,)
            _settle(db, pledge, request["model"], sent)
            usd = most[0] if usage.usd is None else usage.usd
            _enter(db, key, request["model"], usage._replace(usd=usd))
            if answer is not None:
                facts = {name: value for name in _FACTS if (value := getattr(answer, name))} | {"usage": usage}
                asked = without_images(json.dumps(request, ensure_ascii=False), request)
                db.execute(
                    "INSERT OR IGNORE INTO answer (key, text, request, facts) VALUES (?, ?, ?, ?)",
                    (key, answer.raw, asked, json.dumps(facts, ensure_ascii=False)),
                )

    def pledge(
        self, usd: float | None, budget: float | None, seconds: float, key: str = "", model: str = ""
    ) -> int | None:
        """Note a request that is about to be sent, and reserve its maximum cost, until `add` or `release`.

        If this process ends before, the request may have been paid: it goes into the ledger at its maximum cost.

        Args:
            usd: the maximum cost; None: unknown.
            budget: the spending limit, in USD; None: no limit.
            seconds: time after which the request counts as lost, for processes of other machines.
            key: the key of the request.
            model: its model.

        Returns:
            A number for `add` and `release`; None while requests under way leave open whether the budget is enough.

        Raises:
            LookupError: the budget is not enough.
        """
        here, now = socket.gethostname(), time.time()
        with self._writing() as db:
            _enter_lost(db)
            if budget is not None and usd is not None:
                if self.spent() + usd > budget:
                    raise LookupError
                if self.spent() + usd + db.execute("SELECT total(usd) FROM under_way").fetchone()[0] > budget:
                    return None
            row = (now + seconds, usd, here, os.getpid(), key, model)
            return db.execute("INSERT INTO under_way VALUES (NULL, ?, ?, ?, ?, ?, ?)", row).lastrowid

    def release(self, pledge: int | None, model: str, sent: Sent) -> None:
        """End a pledge without a known cost, and count the sent requests."""
        with self._writing() as db:
            _settle(db, pledge, model, sent)

    def served(self, endpoint: str, model: str, id: str | None) -> str:
        """The model that an endpoint serves under a name: `id`, which is stored; if None, the stored one, or empty."""
        if id is None:
            row = self._first("SELECT id FROM served WHERE endpoint = ? AND model = ?", endpoint, model)
            return row[0] if row else ""
        with self._writing() as db:
            db.execute("INSERT OR REPLACE INTO served VALUES (?, ?, ?)", (endpoint, model, id))
        return id

    def form(self, key: str) -> AnswerForm | None:
        """The form that was chosen after a trial; None before it."""
        row = self._first("SELECT name, why FROM form WHERE key = ?", key)
        return AnswerForm(*row) if row else None

    def keep_form(self, key: str, model: str, form: AnswerForm) -> None:
        """Store the form that was chosen for a model; it stays, so that a study that goes on asks in the same form."""
        with self._writing() as db:
            db.execute("INSERT OR IGNORE INTO form VALUES (?, ?, ?, ?)", (key, model, *form))

    def keep_trial(self, key: str) -> None:
        """Note that a request only tries a form of answers."""
        with self._writing() as db:
            db.execute("INSERT OR IGNORE INTO trial VALUES (?)", (key,))

    def spent(self) -> float:
        """USD in the ledger."""
        row = self._first("SELECT total(usd) FROM ledger")
        return float(row[0]) if row else 0.0

    def by_model(self) -> list[dict[str, Any]]:
        """The ledger's sums per model.

        Returns:
            For each model its name, the number of requests with a possible charge (`requests`), their tokens, their
            price in USD, how many of them have an unknown price (`unpriced`), the number of sent requests, and the
            number of requests without a reply (`lost`); after a trial the `form` in which it is asked, with the reason,
            and how many of the `requests` were `trials`.
        """
        with self._writing() as db:
            _enter_lost(db)
        names = ("model", "requests", "input_tokens", "output_tokens", "usd", "unpriced")
        sums = "count(*), coalesce(sum(input_tokens), 0), coalesce(sum(output_tokens), 0), total(usd), sum(usd IS NULL)"
        rows = self._db.execute(f"SELECT model, {sums} FROM ledger GROUP BY model")  # noqa: S608
        paid = {row[0]: dict(zip(names, row, strict=True)) for row in rows}
        sent = {model: counts for model, *counts in self._db.execute("SELECT model, requests, lost FROM sent")}
        forms = {model: {"form": f"{AnswerForm(*form)}"} for model, *form in self._db.execute(_FORMS)}
        tried = "SELECT model, count(*) FROM ledger WHERE key IN (SELECT key FROM trial) GROUP BY model"
        trials = {model: {"trials": number} for model, number in self._db.execute(tried)}
        none = dict(zip(names[1:], (0, 0, 0, 0.0, 0), strict=True))
        return [
            {
                "model": model,
                **none,
                **paid.get(model, {}),
                **dict(zip(("sent", "lost"), counts, strict=True)),
                **forms.get(model, {}),
                **trials.get(model, {}),
            }
            for model in sorted(paid.keys() | sent.keys())
            # files of an earlier release have no counts
            for counts in [sent.get(model, [paid.get(model, none)["requests"], 0])]
        ]

    @contextlib.contextmanager
    def lock(self, key: str) -> Iterator[None]:
        """Lock a request, so that others with the same request wait for its answer."""
        with self._one:
            mine = self._asking.setdefault(key, threading.Lock())
        with mine:
            if fcntl is None or self.path == MEMORY:
                yield
                return
            # The system's locks are between processes; the file stays open, as closing it would release all of them.
            file, place = _lock_file(self.path), int(key[:15], 16)
            fcntl.lockf(file, fcntl.LOCK_EX, 1, place)
            try:
                yield
            finally:
                fcntl.lockf(file, fcntl.LOCK_UN, 1, place)

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def _first(self, query: str, *values: str) -> tuple[Any, ...] | None:
        with self._one:
            row: tuple[Any, ...] | None = self._db.execute(query, values).fetchone()
        return row

    @contextlib.contextmanager
    def _writing(self) -> Iterator[sqlite3.Cursor]:
        """A transaction."""
        with self._one, contextlib.closing(self._db.cursor()) as cursor:
            cursor.execute("BEGIN IMMEDIATE")
            try:
                yield cursor
                cursor.execute("COMMIT")
            except BaseException:
                cursor.execute("ROLLBACK")
                raise


def _settle(db: sqlite3.Cursor, pledge: int | None, model: str, sent: Sent) -> None:
    """End a pledge, and count the sent requests."""
    db.execute("DELETE FROM under_way WHERE id = ?", (pledge,))
    db.execute(
        "INSERT INTO sent VALUES (?, ?, ?) ON CONFLICT (model) DO UPDATE SET requests = requests + excluded.requests, "
        "lost = lost + excluded.lost",
        (model, sent.requests, sent.lost),
    )


def _enter(db: sqlite3.Cursor, key: str, model: str, usage: Usage) -> None:
    """Enter a request into the ledger."""
    row = (time.time(), key, model, usage.input_tokens, usage.output_tokens, usage.usd)
    db.execute("INSERT INTO ledger (time, key, model, input_tokens, output_tokens, usd) VALUES (?, ?, ?, ?, ?, ?)", row)


def _enter_lost(db: sqlite3.Cursor) -> None:
    """Enter the requests whose process was killed, since they may have been paid."""
    here, now = socket.gethostname(), time.time()
    for number, until, usd, host, process, key, model in db.execute("SELECT * FROM under_way").fetchall():
        if until < now or (host == here and not _lives(process)):
            _settle(db, number, model, Sent(1, 1))
            _enter(db, key, model, Usage(usd=usd))


def _lives(process: int) -> bool:
    """Whether a process of this machine lives; True if that is unknown."""
    if fcntl is None:
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


@cache
def _lock_file(path: str) -> int:
    """The lock file of a cache, open as long as the process lives."""
    return os.open(f"{path}-lock", os.O_RDWR | os.O_CREAT, 0o666)


def spending(path: str) -> list[dict[str, Any]]:
    """`Cache.by_model` of a file; empty if the file does not exist."""
    if path == MEMORY or not Path(path).exists():
        return []
    with contextlib.closing(Cache(path)) as cache:
        return cache.by_model()
