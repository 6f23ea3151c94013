"""The store: a study's episodes in one SQLite file, each written whole as it ends."""

import json
import sqlite3
import weakref
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from llf_teacher.studies.episode import EpisodeRow, Record, TurnRow
from llf_teacher.studies.study import EpisodeSpec

SCHEMA_VERSION = 3
_APPLICATION_ID = 0x4C4C4654  # "LLFT"
_TYPES = {str: "TEXT NOT NULL", int: "INTEGER NOT NULL", float: "REAL NOT NULL", bool: "INTEGER NOT NULL"}


def _columns(row: Any) -> str:
    """Column definitions of a row type; a field that may be None may be NULL."""
    kinds = row.__annotations__.items()
    return ", ".join(f"{name} {_TYPES.get(kind, 'INTEGER' if kind == int | None else 'TEXT')}" for name, kind in kinds)


_TABLES = {
    "manifest": ("name", "value"),
    "episode": ("key", *EpisodeSpec._fields, *EpisodeRow._fields),
    "turn": ("episode", *TurnRow._fields),
}
_SCHEMA = f"""
CREATE TABLE manifest (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE episode (key TEXT PRIMARY KEY, {_columns(EpisodeSpec)}, {_columns(EpisodeRow)}) WITHOUT ROWID;
CREATE TABLE turn (episode TEXT NOT NULL REFERENCES episode (key), {_columns(TurnRow)}, PRIMARY KEY (episode, turn))
WITHOUT ROWID;
PRAGMA application_id = {_APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""


class StoreError(ValueError):
    """A file that cannot serve as a store; nothing in it was changed."""


class Store:
    """Episodes on disk. One process writes; others may read meanwhile.

    As a context, it removes a file that it has made if an error leaves it without episodes.

    Args:
        path: the file; it is made if there is none.

    Raises:
        StoreError: the file is of another schema version, incomplete or no store, or cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._made = not path.exists()
        try:
            # A store that nobody uses any more may be collected, and closed, in any thread.
            self._db = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
            weakref.finalize(self, self._db.close)
            self._db.row_factory = sqlite3.Row
            self._prepare()
        except sqlite3.DatabaseError as error:
            raise StoreError(f"cannot use {path} as a store: {error}; give another file by --store") from None

    def _prepare(self) -> None:
        application, version = (
            self._db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")
        )
        empty = not self._db.execute("SELECT 1 FROM sqlite_schema LIMIT 1").fetchone()
        if not empty and application != _APPLICATION_ID:
            raise StoreError(f"{self.path} is a database of something else; give another file by --store")
        if not empty and version != SCHEMA_VERSION:
            raise StoreError(
                f"{self.path} has schema version {version}, this release reads version {SCHEMA_VERSION}; "
                "give another file by --store, or use the release that wrote it"
            )
        for table, columns in () if empty else _TABLES.items():
            there = {row["name"] for row in self._db.execute(f"PRAGMA table_info({table})")}
            if lacking := [name for name in columns if name not in there]:
                raise self._incomplete(f"the table {table} lacks {', '.join(lacking)}")
        self._db.execute("PRAGMA journal_mode = WAL")
        self._db.execute("PRAGMA synchronous = NORMAL")
        if empty:
            self._db.executescript(f"BEGIN IMMEDIATE; {_SCHEMA} COMMIT;")

    def _incomplete(self, what: str) -> StoreError:
        return StoreError(f"{self.path} is no complete store: {what}; give another file by --store")

    def check(self, specs: Iterable[EpisodeSpec]) -> None:
        """Check that of each of these episodes all is there, or nothing.

        Raises:
            StoreError: it is not so.
        """
        said = dict(self._db.execute("SELECT key, turns FROM episode").fetchall())
        for spec in specs:
            found = self._db.execute("SELECT count(*) FROM turn WHERE episode = ?", (spec.key,)).fetchone()[0]
            if found != (said[spec.key] + 1 if spec.key in said else 0):
                raise self._incomplete(f"of the episode {spec._asdict()} only parts are there")

    def add(self, record: Record) -> None:
        """Write an episode and its turns, all or nothing; one that is there already stays as it is."""
        key = record.spec.key
        db = self._db
        db.execute("BEGIN IMMEDIATE")
        try:
            values = (key, *record.spec, *record.episode)
            new = db.execute(f"INSERT OR IGNORE INTO episode VALUES ({_marks(values)})", values).rowcount  # noqa: S608
            if new:
                rows = [(key, *row) for row in record.turns]
                db.executemany(f"INSERT INTO turn VALUES ({_marks(rows[0])})", rows)  # noqa: S608
            db.execute("COMMIT")
        except BaseException:
            db.execute("ROLLBACK")
            raise

    def keys(self) -> set[str]:
        """The keys of the episodes that are there."""
        return {row[0] for row in self._db.execute("SELECT key FROM episode")}

    def episodes(self, keys: set[str] | None = None) -> list[sqlite3.Row]:
        """Episodes in a fixed order: all, or those of the given keys."""
        order = "id, instruction_type, feedback_type, teacher, student, seed, max_turns, version, rules"
        rows = self._db.execute(f"SELECT * FROM episode ORDER BY {order}")  # noqa: S608
        return [row for row in rows if keys is None or row["key"] in keys]

    def turns(self, key: str) -> Iterator[dict[str, Any]]:
        """The turns of an episode, with `action` and `atoms` decoded."""
        for row in self._db.execute("SELECT * FROM turn WHERE episode = ? ORDER BY turn", (key,)):
            turn = dict(row)
            turn["action"] = None if turn["action"] is None else json.loads(turn["action"])
            turn["atoms"] = json.loads(turn["atoms"])
            yield turn

    def regrets(self, key: str) -> list[float]:
        """The regret of each turn of an episode, the opening not included."""
        query = "SELECT regret FROM turn WHERE episode = ? AND turn > 0 ORDER BY turn"
        return [row[0] for row in self._db.execute(query, (key,))]

    def write_manifest(self, values: dict[str, Any]) -> None:
        """Keep facts about the study and its surroundings."""
        rows = [(name, json.dumps(value, ensure_ascii=False)) for name, value in values.items()]
        self._db.executemany("INSERT OR REPLACE INTO manifest VALUES (?, ?)", rows)

    def manifest(self) -> dict[str, Any]:
        """What `write_manifest` kept."""
        rows = self._db.execute("SELECT name, value FROM manifest ORDER BY name")
        return {row["name"]: json.loads(row["value"]) for row in rows}

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        vain = error is not None and self._made and not self.keys()
        self.close()
        if vain:
            self.path.unlink(missing_ok=True)


def _marks(values: tuple[Any, ...]) -> str:
    return ", ".join("?" * len(values))
