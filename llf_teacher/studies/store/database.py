"""The store: a study's episodes in one SQLite file, each written as a whole when it ends.

The table `result` has the columns for tables and curves, `story` the turns as one compressed value, and `setting` what
many episodes share. The view `episode` joins `result` and `setting`. A failed episode is a row of `failure` until it is
played successfully.
"""

import contextlib
import hashlib
import json
import os
import sqlite3
import weakref
import zlib
from collections.abc import Iterable, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

from llf_teacher.episodes.failure import Failure
from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, pack_turns, unpack_regrets, unpack_turns

SCHEMA_VERSION = 4
_APPLICATION_ID = 0x4C4C4654  # "LLFT"
_TYPES = {
    str: "TEXT NOT NULL",
    int: "INTEGER NOT NULL",
    float: "REAL NOT NULL",
    bool: "INTEGER NOT NULL",
    bytes: "BLOB NOT NULL",
    int | None: "INTEGER",
    float | None: "REAL",
}
_FIELDS = EpisodeSpec.__annotations__ | EpisodeRow.__annotations__
_KINDS = _FIELDS | Failure.__annotations__
_OWN = ("seed", *(name for name in EpisodeRow._fields if name not in ("family", "reads")))
_SHARED = tuple(name for name in _FIELDS if name not in _OWN)
_FLAGS = tuple(i for i, kind in enumerate(_FIELDS.values()) if kind is bool)
_of_shared, _of_own = (itemgetter(*map(list(_FIELDS).index, names)) for names in (_SHARED, _OWN))


def _columns(names: Iterable[str]) -> str:
    return ", ".join(f"{name} {_TYPES[_KINDS[name]]}" for name in names)


_TABLES = {
    "manifest": ("name", "value"),
    "setting": ("setting", *_SHARED),
    "result": ("number", "key", "setting", *_OWN, "digest"),
    "story": ("number", "packed"),
    "failure": ("number", "key", *EpisodeSpec._fields, *Failure._fields, "digest"),
    "episode": ("key", *_FIELDS),
}
_FAILED = ", ".join((*EpisodeSpec._fields, *Failure._fields))
_EPISODE = f"lower(hex(key)) AS key, {', '.join(_FIELDS)}"
_JOINED = "result JOIN setting USING (setting)"
_SCHEMA = f"""
CREATE TABLE manifest (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE setting (setting INTEGER PRIMARY KEY, {_columns(_SHARED)}, UNIQUE ({", ".join(_SHARED)}));
CREATE TABLE result (number INTEGER PRIMARY KEY, key BLOB NOT NULL UNIQUE,
setting INTEGER NOT NULL REFERENCES setting (setting), {_columns(_OWN)}, digest BLOB NOT NULL);
CREATE TABLE story (number INTEGER PRIMARY KEY REFERENCES result (number), packed BLOB NOT NULL);
CREATE TABLE failure (number INTEGER PRIMARY KEY, key BLOB NOT NULL UNIQUE, {_columns(EpisodeSpec._fields)},
{_columns(Failure._fields)}, digest BLOB NOT NULL);
CREATE VIEW episode AS SELECT {_EPISODE} FROM {_JOINED};
PRAGMA application_id = {_APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""  # noqa: S608
_PAGE = 16_384  # bytes; smaller pages would be partly empty
_ORDER = "id, instruction_type, feedback_type, teacher, student, seed, max_turns, version, rules"


class StoreError(ValueError):
    """A file cannot serve as a store; it was not changed."""


class Store:
    """Episodes on disk. One process writes; others may read at the same time.

    As a context, it deletes a file that it has created if an error leaves it empty.

    Args:
        path: the file; it is created if it does not exist.

    Raises:
        StoreError: the file has another schema version, is incomplete or no store, or cannot be written.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = path = Path(path)
        self._made = not path.exists()
        try:
            # An unused store may be collected, and closed, in any thread.
            self._db = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
            weakref.finalize(self, self._db.close)
            self._db.row_factory = sqlite3.Row
            self._settings: dict[tuple[Any, ...], int] = {}
            with contextlib.ExitStack() as on_error:
                on_error.callback(self.close)
                self._prepare()
                self._identity = file_identity(path)
                on_error.pop_all()
        except sqlite3.DatabaseError as error:
            raise StoreError(f"cannot use {path} as a store: {error}; give another file by --store") from None

    def _prepare(self) -> None:
        application, version = (
            self._db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")
        )
        empty = not self._db.execute("SELECT 1 FROM sqlite_schema LIMIT 1").fetchone()
        if not empty and application != _APPLICATION_ID:
            raise StoreError(f"{self.path} is another kind of database; give another file by --store")
        if not empty and version != SCHEMA_VERSION:
            raise StoreError(
                f"{self.path} has schema version {version}, this release reads version {SCHEMA_VERSION}; give another "
                "file by --store, convert it by `llf study migrate`, or use the release that wrote it"
            )
        for table, columns in () if empty else _TABLES.items():
            there = {row["name"] for row in self._db.execute(f"PRAGMA table_info({table})")}
            if lacking := [name for name in columns if name not in there]:
                raise self._incomplete(f"the table {table} lacks {', '.join(lacking)}")
        if empty:
            self._db.execute(f"PRAGMA page_size = {_PAGE}")
        self._db.execute("PRAGMA journal_mode = WAL")
        self._db.execute("PRAGMA synchronous = NORMAL")
        if empty:
            self._db.executescript(f"BEGIN IMMEDIATE; {_SCHEMA} COMMIT;")

    def _incomplete(self, what: str) -> StoreError:
        return StoreError(f"{self.path} is incomplete or damaged: {what}; give another file by --store")

    def check(self) -> None:
        """Check that every episode is complete.

        Raises:
            StoreError: an episode is not.
        """
        for number, problem in self.damage():
            raise self._incomplete(f"{problem} (row {number})")

    def damage(self, *, thorough: bool = False) -> Iterator[tuple[int, str]]:
        """Damage: the number of a row of `result`, `story` or `failure` (0: of the file), and what is wrong with it.

        Args:
            thorough: whether to compare everything with its digest; else only missing rows are found.
        """
        for here, there in (("result", "story"), ("story", "result")):
            query = f"SELECT number FROM {here} WHERE number NOT IN (SELECT number FROM {there})"  # noqa: S608
            for (number,) in self._db.execute(query):
                yield number, "an episode is incomplete"
        if thorough:
            for (message,) in self._db.execute("PRAGMA integrity_check"):
                if message != "ok":
                    yield 0, message
            query = f"SELECT number, digest, {_EPISODE}, packed FROM {_JOINED} JOIN story USING (number)"  # noqa: S608
            for number, digest, key, *values, packed in self._db.execute(query):
                if _digest(key, values, packed) != digest:
                    yield number, f"the episode {key} differs from its digest"
            query = f"SELECT number, digest, lower(hex(key)), {_FAILED} FROM failure"  # noqa: S608
            for number, digest, key, *values in self._db.execute(query):
                if _digest(key, values) != digest:
                    yield number, f"the failure of the episode {key} differs from its digest"

    def add(self, record: Record) -> None:
        """Write an episode and its turns, all or nothing; an episode that is there stays unchanged."""
        self.add_packed(record.spec, record.episode, pack_turns(record.turns))

    def add_packed(self, spec: EpisodeSpec, episode: EpisodeRow, turns: bytes) -> None:
        """Write an episode whose turns `pack_turns` has packed; see `add`."""
        values: list[Any] = [*spec, *episode]
        for i in _FLAGS:
            values[i] = int(values[i])
        key = spec.key
        with self._writing() as db:
            setting = self._setting(_of_shared(values))
            row = (bytes.fromhex(key), setting, *_of_own(values), _digest(key, values, turns))
            added = db.execute(f"INSERT OR IGNORE INTO result VALUES (NULL, {_marks(row)})", row)  # noqa: S608
            if added.rowcount:
                db.execute("INSERT INTO story VALUES (?, ?)", (added.lastrowid, turns))
                db.execute("DELETE FROM failure WHERE key = ?", row[:1])

    def add_failure(self, spec: EpisodeSpec, failure: Failure) -> None:
        """Write why an episode failed; an earlier failure is replaced."""
        row = (bytes.fromhex(spec.key), *spec, *failure, _digest(spec.key, (*spec, *failure)))
        with self._writing() as db:
            db.execute(f"INSERT OR REPLACE INTO failure VALUES (NULL, {_marks(row)})", row)  # noqa: S608

    def packed(self) -> Iterator[tuple[EpisodeSpec, EpisodeRow, bytes]]:
        """All episodes, as `add_packed` takes them."""
        query = f"SELECT {', '.join(_FIELDS)}, packed FROM {_JOINED} JOIN story USING (number)"  # noqa: S608
        size = len(EpisodeSpec._fields)
        for *values, turns in self._db.execute(query):
            yield EpisodeSpec(*values[:size]), EpisodeRow(*values[size:]), turns

    def failed(self) -> Iterator[tuple[EpisodeSpec, Failure]]:
        """All failed episodes, as `add_failure` takes them."""
        size = len(EpisodeSpec._fields)
        for values in self._db.execute(f"SELECT {_FAILED} FROM failure"):  # noqa: S608
            yield EpisodeSpec(*values[:size]), Failure(*values[size:])

    def failures(self) -> Iterator[dict[str, Any]]:
        """The failed episodes: `key`, the fields of `EpisodeSpec`, and those of `Failure`."""
        query = f"SELECT lower(hex(key)) AS key, {_FAILED} FROM failure ORDER BY {_ORDER}"  # noqa: S608
        yield from map(dict, self._db.execute(query))

    @contextlib.contextmanager
    def together(self) -> Iterator[None]:
        """Write everything that is added within in one transaction, which is faster for many episodes."""
        with self._writing():
            yield

    @contextlib.contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """A transaction; a nested one joins the outer one.

        Raises:
            StoreError: the file is gone or cannot be written.
        """
        db = self._db
        if db.in_transaction:
            yield db
            return
        self.check_file()
        try:
            db.execute("BEGIN IMMEDIATE")
            yield db
            db.execute("COMMIT")
        except BaseException as error:
            self._settings.clear()
            with contextlib.suppress(sqlite3.Error):
                if db.in_transaction:  # SQLite may have ended it
                    db.execute("ROLLBACK")
            if isinstance(error, sqlite3.OperationalError):
                raise StoreError(
                    f"cannot write to {self.path}: {error}; earlier episodes are in it. Solve this, and run the same "
                    "command to go on"
                ) from None
            raise

    def check_file(self) -> None:
        """Check that the path still names the open file.

        Raises:
            StoreError: the file was deleted, moved or replaced.
        """
        if file_identity(self.path) != self._identity:
            raise StoreError(
                f"{self.path} was deleted, moved or replaced while it was in use, so that nothing more can be stored; "
                "if it was moved, put it back, and run the same command to go on"
            )

    def _setting(self, shared: tuple[Any, ...]) -> int:
        if shared not in self._settings:
            same = " AND ".join(f"{name} = ?" for name in _SHARED)
            self._db.execute(f"INSERT OR IGNORE INTO setting VALUES (NULL, {_marks(shared)})", shared)  # noqa: S608
            found = self._db.execute(f"SELECT setting FROM setting WHERE {same}", shared).fetchone()  # noqa: S608
            self._settings[shared] = found[0]
        return self._settings[shared]

    @property
    def count(self) -> int:
        """Number of episodes."""
        (count,) = self._db.execute("SELECT count(*) FROM result").fetchone()
        return int(count)

    def keys(self) -> set[str]:
        """The keys of all episodes."""
        return {row[0] for row in self._db.execute("SELECT key FROM episode")}

    def has(self, key: str) -> bool:
        """Whether the store has an episode."""
        return self._found("SELECT 1 FROM result WHERE key = ?", bytes.fromhex(key))

    def has_failed(self, key: str) -> bool:
        """Whether an episode has failed and was not played since."""
        return self._found("SELECT 1 FROM failure WHERE key = ?", bytes.fromhex(key))

    @property
    def empty(self) -> bool:
        """Whether there is neither an episode nor a failed one."""
        return not self._found("SELECT 1 FROM result LIMIT 1") and not self._found("SELECT 1 FROM failure LIMIT 1")

    def _found(self, query: str, *values: Any) -> bool:
        return self._db.execute(query, values).fetchone() is not None

    def episodes(self, keys: set[str] | None = None) -> list[sqlite3.Row]:
        """Episodes in a fixed order: all, or those with the given keys."""
        rows = self._db.execute(f"SELECT * FROM episode ORDER BY {_ORDER}")  # noqa: S608
        return [row for row in rows if keys is None or row["key"] in keys]

    def episode(self, key: str) -> sqlite3.Row:
        """An episode.

        Raises:
            StoreError: the store does not have it.
        """
        query = f"SELECT {_EPISODE} FROM {_JOINED} WHERE key = ?"  # noqa: S608
        row: sqlite3.Row | None = self._db.execute(query, (_key(key),)).fetchone()
        if row is None:
            raise StoreError(f"{self.path} has no episode {key!r}; `llf study export` writes the keys of all")
        return row

    def rows(self) -> Iterator[dict[str, Any]]:
        """All episodes one by one, decoded, in the order in which they were written."""
        for row in map(dict, self._db.execute("SELECT * FROM episode")):
            yield {**row, "success": bool(row["success"]), "regrets": unpack_regrets(row["regrets"]).tolist()}

    def turns(self, key: str) -> list[dict[str, Any]]:
        """The turns of an episode, with `action` and `atoms` decoded.

        Raises:
            StoreError: they cannot be read.
        """
        query = "SELECT number, packed FROM story JOIN result USING (number) WHERE key = ?"
        row = self._db.execute(query, (_key(key),)).fetchone()
        try:
            return unpack_turns(row["packed"]) if row else []
        except (zlib.error, ValueError) as error:
            raise self._incomplete(
                f"the turns of the episode {key} (row {row['number']}) cannot be read: {error}"
            ) from None

    def regrets(self, key: str) -> list[float]:
        """The regret of each turn of an episode, the opening not included."""
        query = "SELECT regrets FROM result WHERE key = ?"
        return [each for row in self._db.execute(query, (_key(key),)) for each in unpack_regrets(row[0]).tolist()]

    def answers(self) -> list[sqlite3.Row]:
        """Per student that asks a model: its episodes, and sums of answers and costs; null if an addend is unknown."""
        sums = ", ".join(f"sum({name}) AS {name}" for name in ("answers", "truncated", "parse_failures"))
        known = ", ".join(
            f"CASE WHEN count({name}) = count(*) THEN total({name}) END AS {name}"
            for name in ("input_tokens", "output_tokens", "usd", "seconds")
        )
        return self._db.execute(
            f"SELECT student, count(*) AS episodes, {sums}, {known} FROM episode WHERE answers IS NOT NULL "  # noqa: S608
            "GROUP BY student ORDER BY student"
        ).fetchall()

    def write_manifest(self, values: dict[str, Any]) -> None:
        """Write facts about the study and its software."""
        rows = [(name, json.dumps(value, ensure_ascii=False)) for name, value in values.items()]
        with self._writing() as db:
            db.executemany("INSERT OR REPLACE INTO manifest VALUES (?, ?)", rows)

    def manifest(self) -> dict[str, Any]:
        """All that `write_manifest` has written."""
        rows = self._db.execute("SELECT name, value FROM manifest ORDER BY name")
        return {row["name"]: json.loads(row["value"]) for row in rows}

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        useless = error is not None and self._made and self.empty and file_identity(self.path) == self._identity
        self.close()
        if useless:
            self.path.unlink(missing_ok=True)


@contextlib.contextmanager
def read_only(path: Path) -> Iterator[sqlite3.Connection]:
    """A connection to a store of any schema version, which is closed at the end and cannot write."""
    with contextlib.closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as db:
        yield db


def _marks(values: tuple[Any, ...]) -> str:
    return ", ".join("?" * len(values))


def _key(key: str) -> bytes:
    """A key as bytes; empty if the text is no key."""
    try:
        return bytes.fromhex(key)
    except ValueError:
        return b""


def file_identity(path: Path | int) -> tuple[int, int] | None:
    """Device and inode of the file at a path, or of an open file by its number; None if there is none."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino


def _digest(key: str, values: Iterable[Any], turns: bytes = b"") -> bytes:
    """A digest of everything that is stored of an episode."""
    digest = hashlib.blake2b(repr((key, *values)).encode(), digest_size=8)
    digest.update(turns)
    return digest.digest()
