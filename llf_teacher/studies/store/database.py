"""The store: a study's episodes in one SQLite file, each written as a whole when it ends.

The table `result` has the columns for tables and curves, `story` the turns as one compressed value, and `setting` the
fields that many episodes share. The view `episode` joins `result` and `setting`. A failed episode is a row of `failure`
until it is played successfully. `definition` has every definition that the study has had, by the `revision` in its
episodes, and `manifest` the newest facts. Each row has a digest of its values, and `seal` has for each table the number
of rows and a digest of all digests, to detect changed values and missing rows.
"""

import contextlib
import hashlib
import json
import sqlite3
import weakref
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from operator import itemgetter
from pathlib import Path
from typing import Any

from llf_teacher.episodes.failure import Failure
from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, pack_turns, unpack_regrets, unpack_turns
from llf_teacher.studies.store import files

SCHEMA_VERSION = 9
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
_OWN = ("seed", *(name for name in EpisodeRow._fields if name not in ("family", "reads", "why")))
_SHARED = tuple(name for name in _FIELDS if name not in _OWN)
_FLAGS = tuple(i for i, kind in enumerate(_FIELDS.values()) if kind is bool)
_of_shared, _of_own = (itemgetter(*map(list(_FIELDS).index, names)) for names in (_SHARED, _OWN))


def _columns(names: Iterable[str]) -> str:
    return ", ".join(f"{name} {_TYPES[_KINDS[name]]}" for name in names)


_FAILED = ", ".join((*EpisodeSpec._fields, *Failure._fields))
_EPISODE = f"lower(hex(key)) AS key, {', '.join(_FIELDS)}"
_JOINED = "result JOIN setting USING (setting)"
_SEALED = {"result": "number", "failure": "number", "definition": "revision", "manifest": "name"}
"""The tables of the seal, and the columns that identify their rows."""
_SCHEMA = f"""
CREATE TABLE manifest (name TEXT PRIMARY KEY, value TEXT NOT NULL, digest BLOB NOT NULL) WITHOUT ROWID;
CREATE TABLE definition (revision INTEGER PRIMARY KEY, facts TEXT NOT NULL UNIQUE, digest BLOB NOT NULL);
CREATE TABLE setting (setting INTEGER PRIMARY KEY, {_columns(_SHARED)}, UNIQUE ({", ".join(_SHARED)}));
CREATE TABLE result (number INTEGER PRIMARY KEY, key BLOB NOT NULL UNIQUE,
setting INTEGER NOT NULL REFERENCES setting (setting), {_columns(_OWN)}, revision INTEGER NOT NULL,
digest BLOB NOT NULL);
CREATE TABLE story (number INTEGER PRIMARY KEY REFERENCES result (number), packed BLOB NOT NULL);
CREATE TABLE failure (number INTEGER PRIMARY KEY, key BLOB NOT NULL UNIQUE, {_columns(EpisodeSpec._fields)},
{_columns(Failure._fields)}, digest BLOB NOT NULL);
CREATE TABLE seal (sealed TEXT PRIMARY KEY, rows INTEGER NOT NULL, digest BLOB NOT NULL) WITHOUT ROWID;
CREATE VIEW episode AS SELECT {_EPISODE}, revision FROM {_JOINED};
{"".join(f"INSERT INTO seal VALUES ('{table}', 0, zeroblob(8));" for table in _SEALED)}
PRAGMA application_id = {_APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""  # noqa: S608
_BYTES = 8  # of a digest
_HALF = "an episode is incomplete"
_PAGE = 16_384  # bytes; smaller pages would be partly empty
_ORDER = "id, instruction_type, feedback_type, teacher, student, seed, max_turns, version, rules"

_ANOTHER = "give another file (`llf study run` and `report` take it by --store)"

_WHOLE = (
    "`llf study check` names what is damaged, `llf study rescue` copies the episodes that are whole, and `llf study "
    "archive` copies a store that is in use"
)


class StoreError(ValueError):
    """A file cannot serve as a store; it was not changed."""


class Store:
    """Episodes on disk. One process writes; others may read at the same time.

    As a context manager, it deletes a file that it has created if an error leaves it empty.

    Args:
        path: the file; it is created if it does not exist, except with `read_only`.
        read_only: whether to write nothing, so that the file's folder may be read-only.

    Raises:
        StoreError: the file has another schema version, is damaged or no store, or cannot be written; or it does not
        exist, with `read_only`.
    """

    def __init__(self, path: Path | str, *, read_only: bool = False) -> None:
        self.path = path = Path(path)
        if read_only and not path.is_file():
            raise StoreError(f"there is no file {path}; give a store that `llf study run` made")
        self._made = not path.exists()
        self._cut = read_only and files.log_is_cut(path)
        if not read_only and files.log_of(path).exists():
            with Store(path, read_only=True) as before:  # closing it for writing would empty a wrong log into the file
                before.check_rows()
        try:
            self._db = files.connect(path, read_only=read_only)
            weakref.finalize(self, files.close, self._db)  # in any thread
            self._db.row_factory = sqlite3.Row
            self._logs = False
            self._settings: dict[tuple[Any, ...], int] = {}
            self._changes: dict[str, tuple[int, int]] = {}
            """The current transaction's changes of the seal: the number of rows, and the digests, by table."""
            with contextlib.ExitStack() as on_error:
                on_error.callback(self.close)
                self._prepare(read_only)
                self.revision = self._last_revision()
                """The revision of added episodes; 0: no definition."""
                self._identity = files.file_identity(path)
                on_error.pop_all()
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
            raise StoreError(f"cannot use {path} as a store: {error}; {_ANOTHER}") from None

    def _prepare(self, read_only: bool) -> None:
        application, version = (
            self._db.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")
        )
        schema = _schema(self._db)
        if schema and application != _APPLICATION_ID:
            raise StoreError(f"{self.path} is another kind of database; {_ANOTHER}")
        if schema and version != SCHEMA_VERSION:
            raise StoreError(
                f"{self.path} is a store of schema version {version}, and must be of version {SCHEMA_VERSION}; "
                f"play the study again, and {_ANOTHER}"
            )
        if not schema and read_only:
            raise StoreError(f"{self.path} is empty; give a store that `llf study run` made")
        for name, sql in _schema_of_a_store().items() if schema else ():
            if schema.get(name) != sql:
                raise self._damaged(f"its {name} {'is defined otherwise' if name in schema else 'is missing'}")
        if not schema:
            self._db.execute(f"PRAGMA page_size = {_PAGE}")
            self._db.executescript(f"BEGIN IMMEDIATE; {_SCHEMA} COMMIT;")

    def _damaged(self, what: str) -> StoreError:
        return StoreError(f"{self.path} is incomplete or damaged: {what}; {_WHOLE}, or {_ANOTHER}")

    def check(self) -> None:
        """Check that the store has all rows as they were written, and each episode its turns.

        Raises:
            StoreError: it has not.
        """
        if problem := self.lost_log():
            raise self._damaged(problem)
        self.check_rows()

    def check_rows(self) -> None:
        """The same for the rows that can be read: a run plays what a lost log had again.

        Raises:
            StoreError: a row is missing, or differs from what was written.
        """
        try:
            with self._same_state():
                for table, number in self._halves():
                    raise self._damaged(f"{_HALF} ({table}, row {number})")
                for _, _, problem in self._broken_seals():
                    if problem:
                        raise self._damaged(problem)
                for _, read in self._tables():
                    for table, row, problem in read():
                        if problem:
                            raise self._damaged(f"{problem} ({table}, row {row})")
        except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
            raise self._damaged(f"{error}") from None

    @contextlib.contextmanager
    def _same_state(self) -> Iterator[None]:
        """A context in which all queries see the same state, while other processes may write."""
        self._db.execute("SAVEPOINT state")
        try:
            yield
        finally:
            with contextlib.suppress(sqlite3.Error):
                self._db.execute("RELEASE state")

    def _halves(self) -> Iterator[tuple[str, int]]:
        """Rows of `result` without turns, and the other way round."""
        for here, there in (("result", "story"), ("story", "result")):
            query = f"SELECT number FROM {here} WHERE number NOT IN (SELECT number FROM {there})"  # noqa: S608
            for (number,) in self._db.execute(query):
                yield here, number

    def damage(self) -> Iterator[tuple[str, int | str, str]]:
        """The damage of the store: a table or `file`, the damaged row or the last one before it, and the problem.

        It compares the values of each row with the row's digest, and the rows with the seal of their table. Other
        processes may write at the same time.
        """
        if problem := self.lost_log():
            yield "file", 0, problem
        with self._same_state():
            self._db.text_factory = lambda text: text.decode("utf-8", "backslashreplace")  # which breaks its digest
            try:
                for table, read in (
                    ("file", self._broken_pages),
                    *self._tables(),
                    ("seal", self._broken_seals),
                ):
                    row: int | str = 0
                    try:
                        for table, row, problem in read():
                            if problem:
                                yield table, row, problem
                    except (sqlite3.Error, UnicodeError, OverflowError) as error:
                        yield table, row, f"what follows this row cannot be read: {error}"
            finally:
                self._db.text_factory = str

    def _tables(self) -> tuple[tuple[str, Callable[[], Iterator[tuple[str, int | str, str]]]], ...]:
        """Per table with digests, what compares its rows with them."""
        return (
            ("result", self._broken_episodes),
            ("failure", self._broken_failures),
            ("definition", lambda: self._broken_facts("definition", "revision, facts")),
            ("manifest", lambda: self._broken_facts("manifest", "name, value")),
        )

    def lost_log(self) -> str:
        """The problem of a copy whose log is missing or cut; empty for other files."""
        log = files.log_of(self.path).name
        if self._cut:
            return (
                f"episodes may be missing: its log, {log}, has no end; copy both files when no run writes to them, or "
                "let `llf study run` play what is missing"
            )
        if files.has_lost_its_log(self.path):
            return (
                f"episodes may be missing: it was copied without its log, {log}, in which the newest are; copy both, "
                "or let `llf study run` play what is missing"
            )
        return ""

    def _broken_pages(self) -> Iterator[tuple[str, int | str, str]]:
        for (message,) in self._db.execute("PRAGMA integrity_check"):
            yield "file", 0, "" if message == "ok" else message

    def _broken_episodes(self) -> Iterator[tuple[str, int | str, str]]:
        for table, number in self._halves():
            yield table, number, _HALF
        query = (
            f"SELECT number, digest, lower(hex(key)), revision, {', '.join(_FIELDS)}, packed "  # noqa: S608
            "FROM result LEFT JOIN setting USING (setting) JOIN story USING (number) ORDER BY number"
        )
        for number, digest, key, *values, packed in self._db.execute(query):
            differs = not isinstance(packed, bytes) or digest_of((key, *values), packed) != digest
            yield "result", number, f"the episode {key} differs from its digest" if differs else ""

    def _broken_failures(self) -> Iterator[tuple[str, int | str, str]]:
        query = f"SELECT number, digest, lower(hex(key)), {_FAILED} FROM failure ORDER BY number"  # noqa: S608
        for number, digest, key, *values in self._db.execute(query):
            differs = digest_of((key, *values)) != digest
            yield "failure", number, f"the failure of the episode {key} differs from its digest" if differs else ""

    def _broken_facts(self, table: str, columns: str) -> Iterator[tuple[str, int | str, str]]:
        for digest, *values in self._db.execute(f"SELECT digest, {columns} FROM {table}"):  # noqa: S608
            yield table, values[0], "" if digest_of(values) == digest else "it differs from its digest"

    def _broken_seals(self) -> Iterator[tuple[str, int | str, str]]:
        seals = {name: (rows, digest) for name, rows, digest in self._db.execute("SELECT * FROM seal")}
        for table in _SEALED:
            rows, total = 0, 0
            for (digest,) in self._db.execute(f"SELECT digest FROM {table}"):  # noqa: S608
                rows, total = rows + 1, total ^ _number(digest)
            sealed, all_digests = seals.get(table, (None, b""))
            problem = ""
            if rows != sealed:
                problem = f"the table {table} has {rows} rows instead of {sealed}"
            elif total != _number(all_digests):
                problem = f"the table {table} has other rows than those that were written"
            yield "seal", table, problem

    def add(self, record: Record) -> None:
        """Write an episode and its turns, all or nothing; an existing episode stays unchanged."""
        self.add_packed(record.spec, record.episode, pack_turns(record.turns))

    def add_packed(self, spec: EpisodeSpec, episode: EpisodeRow, turns: bytes) -> None:
        """Write an episode with turns packed by `pack_turns`; see `add`."""
        values: list[Any] = [*spec, *episode]
        for i in _FLAGS:
            values[i] = int(values[i])
        key = spec.key
        with self._writing() as db:
            setting = self._setting(_of_shared(values))
            digest = digest_of((key, self.revision, *values), turns)
            row = (bytes.fromhex(key), setting, *_of_own(values), self.revision, digest)
            added = db.execute(f"INSERT OR IGNORE INTO result VALUES (NULL, {_marks(row)})", row)  # noqa: S608
            if added.rowcount:
                db.execute("INSERT INTO story VALUES (?, ?)", (added.lastrowid, turns))
                self._count("result", digest)
                self._delete("failure", "key", row[0])

    def add_failure(self, spec: EpisodeSpec, failure: Failure) -> None:
        """Write why an episode failed; an earlier failure is replaced."""
        digest = digest_of((spec.key, *spec, *failure))
        row = (bytes.fromhex(spec.key), *spec, *failure, digest)
        with self._writing() as db:
            self._delete("failure", "key", row[0])
            db.execute(f"INSERT INTO failure VALUES (NULL, {_marks(row)})", row)  # noqa: S608
            self._count("failure", digest)

    def remove(self, keys: Iterable[str]) -> None:
        """Remove episodes with their turns, all or nothing."""
        with self._writing() as db:
            for key in map(_key, keys):
                db.execute("DELETE FROM story WHERE number IN (SELECT number FROM result WHERE key = ?)", (key,))
                self._delete("result", "key", key)

    def _delete(self, table: str, column: str, value: Any) -> None:
        """Delete a row, if it exists."""
        for (digest,) in self._db.execute(f"DELETE FROM {table} WHERE {column} = ? RETURNING digest", (value,)):  # noqa: S608
            self._count(table, digest, -1)

    def _count(self, table: str, digest: bytes, added: int = 1) -> None:
        """Note a row that the current transaction adds or deletes, for the seal."""
        rows, digests = self._changes.get(table, (0, 0))
        self._changes[table] = rows + added, digests ^ _number(digest)

    def _seal(self) -> None:
        for table, (added, digests) in self._changes.items():
            sealed = self._db.execute("SELECT digest FROM seal WHERE sealed = ?", (table,)).fetchone()
            if sealed is None or not isinstance(sealed[0], bytes):
                raise self._damaged(f"the table {table} has no seal")
            now = (_number(sealed[0]) ^ digests).to_bytes(_BYTES)
            self._db.execute("UPDATE seal SET rows = rows + ?, digest = ? WHERE sealed = ?", (added, now, table))
        self._changes.clear()

    def packed(self) -> Iterator[tuple[int, EpisodeSpec, EpisodeRow, bytes]]:
        """All episodes: the revision of each, and the arguments of `add_packed`."""
        query = f"SELECT revision, {', '.join(_FIELDS)}, packed FROM {_JOINED} JOIN story USING (number)"  # noqa: S608
        size = len(EpisodeSpec._fields)
        for revision, *values, turns in self._db.execute(query):
            yield revision, EpisodeSpec(*values[:size]), EpisodeRow(*values[size:]), turns

    def whole(self) -> Iterator[tuple[int, EpisodeSpec, EpisodeRow, bytes]]:
        """As `packed`, the episodes of a damaged store that agree with their digests."""
        query = (
            f"SELECT revision, {', '.join(_FIELDS)}, packed, digest, lower(hex(key)) FROM {_JOINED} "  # noqa: S608
            "JOIN story USING (number) WHERE number = ?"
        )
        size = len(EpisodeSpec._fields)
        for number in range(1, 1 + self._last_number()):
            with contextlib.suppress(sqlite3.Error, UnicodeError, OverflowError):  # its page, or only its row
                for revision, *values, turns, digest, key in self._db.execute(query, (number,)).fetchall():
                    if isinstance(turns, bytes) and digest_of((key, revision, *values), turns) == digest:
                        yield revision, EpisodeSpec(*values[:size]), EpisodeRow(*values[size:]), turns

    def _last_number(self) -> int:
        """The greatest number of an episode, from whatever of it can be read."""
        found = [0]
        for column in ("max(number) FROM result", "max(number) FROM story", "max(rows) FROM seal"):
            with contextlib.suppress(sqlite3.Error, TypeError, ValueError):
                found.append(int(self._db.execute(f"SELECT {column}").fetchone()[0]))
        return max(found)

    def sealed(self) -> int | None:
        """The number of episodes that were written, by the seal; None if it cannot be read."""
        try:
            return int(self._db.execute("SELECT rows FROM seal WHERE sealed = 'result'").fetchone()[0])
        except (sqlite3.Error, TypeError, ValueError):
            return None

    def whole_facts(self, table: str) -> dict[Any, Any]:
        """Of a damaged store, the rows of `definition` or `manifest` that agree with their digests."""
        columns = {"definition": "revision, facts", "manifest": "name, value"}[table]
        found: dict[Any, Any] = {}
        with contextlib.suppress(sqlite3.Error, UnicodeError):  # what follows cannot be read
            for digest, name, text in self._db.execute(f"SELECT digest, {columns} FROM {table}"):  # noqa: S608
                if digest_of((name, text)) == digest:
                    found[name] = json.loads(text)
        return found

    def failed(self) -> Iterator[tuple[EpisodeSpec, Failure]]:
        """All failed episodes, as arguments of `add_failure`."""
        size = len(EpisodeSpec._fields)
        for values in self._db.execute(f"SELECT {_FAILED} FROM failure"):  # noqa: S608
            yield EpisodeSpec(*values[:size]), Failure(*values[size:])

    def failures(self) -> Iterator[dict[str, Any]]:
        """The failed episodes: `key`, the fields of `EpisodeSpec`, and those of `Failure`."""
        query = f"SELECT lower(hex(key)) AS key, {_FAILED} FROM failure ORDER BY {_ORDER}"  # noqa: S608
        yield from map(dict, self._db.execute(query))

    @contextlib.contextmanager
    def together(self) -> Iterator[None]:
        """Write all additions in the context in one transaction, which is faster for many episodes."""
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
            if not self._logs:
                files.begin_writing(db)
                self._logs = True
            db.execute("BEGIN IMMEDIATE")
            yield db
            self._seal()
            db.execute("COMMIT")
        except BaseException as error:
            self._settings.clear()
            self._changes.clear()
            with contextlib.suppress(sqlite3.Error):
                if db.in_transaction:  # SQLite may have ended the transaction
                    db.execute("ROLLBACK")
            if isinstance(error, OverflowError):
                raise StoreError(
                    f"{self.path} holds integers below 2**63, got a greater one; give smaller numbers"
                ) from None
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
        if files.file_identity(self.path) != self._identity:
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

    def revision_of(self, key: str) -> int | None:
        """The revision of an episode's definition; None if the store does not have the episode."""
        row = self._db.execute("SELECT revision FROM result WHERE key = ?", (_key(key),)).fetchone()
        return None if row is None else int(row[0])

    def versions(self) -> list[tuple[str, str, str]]:
        """Each id that has had episodes, with their `version` and `rules`."""
        query = "SELECT DISTINCT id, version, rules FROM setting ORDER BY id, version, rules"
        return [(id, version, rules) for id, version, rules in self._db.execute(query)]

    def coded(self) -> Iterator[tuple[frozenset[str], int, int]]:
        """What may have code of its own in some episodes, the revision of these, and their number."""
        names = "id, teacher, student, reader, taught"
        query = f"SELECT revision, count(*), {names} FROM episode GROUP BY revision, {names}"  # noqa: S608
        for revision, number, *specs in self._db.execute(query):
            yield frozenset(specs), revision, number

    def has_failed(self, key: str) -> bool:
        """Whether an episode failed and was not played later."""
        return self._found("SELECT 1 FROM failure WHERE key = ?", bytes.fromhex(key))

    @property
    def empty(self) -> bool:
        """Whether there are neither episodes nor failures."""
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
        """All episodes one by one, decoded, in the order of writing."""
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
            raise self._damaged(
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

    def define(self, facts: Mapping[str, Any]) -> int:
        """Set the definition of the next episodes: a new revision, unless the store has it already.

        Args:
            facts: JSON values: the study, and the versions of its software. They go into the manifest, too.

        Returns:
            The revision.
        """
        text = _json(facts)
        with self._writing() as db:
            self.write_manifest(facts)
            found = db.execute("SELECT revision FROM definition WHERE facts = ?", (text,)).fetchone()
            self.revision = found[0] if found else 1 + self._last_revision()
            if not found:
                row = (self.revision, text)
                db.execute("INSERT INTO definition VALUES (?, ?, ?)", (*row, digest_of(row)))
                self._count("definition", digest_of(row))
        return self.revision

    def definitions(self) -> dict[int, dict[str, Any]]:
        """The definitions from `define`, by revision; revision 0 means no definition."""
        return self._facts("SELECT revision, facts FROM definition ORDER BY revision")

    def _last_revision(self) -> int:
        (revision,) = self._db.execute("SELECT coalesce(max(revision), 0) FROM definition").fetchone()
        return int(revision)

    def _facts(self, query: str) -> dict[Any, Any]:
        try:
            return {name: json.loads(value) for name, value in self._db.execute(query)}
        except (ValueError, sqlite3.DatabaseError) as error:
            raise self._damaged(f"its definition cannot be read, {error}") from None

    def write_manifest(self, values: Mapping[str, Any]) -> None:
        """Write facts about the study and its software; earlier ones of the same names are replaced."""
        with self._writing() as db:
            for name, value in values.items():
                row = (name, _json(value))
                self._delete("manifest", "name", name)
                db.execute("INSERT INTO manifest VALUES (?, ?, ?)", (*row, digest_of(row)))
                self._count("manifest", digest_of(row))

    def manifest(self) -> dict[str, Any]:
        """All facts from `write_manifest`."""
        return self._facts("SELECT name, value FROM manifest ORDER BY name")

    def back_up(self, path: Path) -> None:
        """Write a whole, consistent copy of the store; others may write to the store at the same time.

        Raises:
            StoreError: the store is not whole; a copy of it would hide this.
        """
        self.check()
        with contextlib.closing(files.connect(path)) as copy:
            self._db.backup(copy)
            files.close(copy)

    def close(self) -> None:
        """Close the file."""
        files.close(self._db)

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, *_: object) -> None:
        if isinstance(error, sqlite3.DatabaseError):
            self.close()
            raise self._damaged(f"{error}") from None
        useless = error is not None and self._made and self.empty and files.file_identity(self.path) == self._identity
        self.close()
        if useless:
            self.path.unlink(missing_ok=True)


def _marks(values: tuple[Any, ...]) -> str:
    return ", ".join("?" * len(values))


def _key(key: str) -> bytes:
    """A key as bytes; empty if the text is not a key."""
    try:
        return bytes.fromhex(key)
    except ValueError:
        return b""


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def digest_of(values: Iterable[Any], turns: bytes = b"") -> bytes:
    """A digest of all values in a row, and of the turns of an episode."""
    digest = hashlib.blake2b(repr(tuple(values)).encode(), digest_size=_BYTES)
    digest.update(turns)
    return digest.digest()


def _number(digest: Any) -> int:
    """A digest as a number; -1 if the value is not a digest."""
    return int.from_bytes(digest) if isinstance(digest, bytes) else -1


def _schema(db: sqlite3.Connection) -> dict[str, str]:
    """The schema of a database: the text that defines each table and view, by name."""
    return {name: f"{sql}" for name, sql in db.execute("SELECT name, sql FROM sqlite_schema")}


@cache
def _schema_of_a_store() -> dict[str, str]:
    with contextlib.closing(sqlite3.connect(":memory:", isolation_level=None)) as db:
        db.executescript(_SCHEMA)
        return _schema(db)
