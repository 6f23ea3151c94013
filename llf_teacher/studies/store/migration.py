"""Migration of stores of earlier schema versions."""

import json
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from llf_teacher.episodes.failure import Failure
from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, TurnRow, summary, unpack_turns
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.database import SCHEMA_VERSION, digest_of
from llf_teacher.studies.store.files import reading

_JOINED = "result JOIN setting USING (setting) JOIN story USING (number)"
_SUCCESS, _ATOMS = map(TurnRow._fields.index, ("success", "atoms"))
_CHECKED = ("turns", "success", "first_success", "parse_failures", "claims", "claims_held", "words")


def migrate(old: Path, new: Path, progress: Callable[[int, int], object] | None = None) -> int:
    """Copy the episodes, turns and manifest of an older store into a new one; the old one is only read.

    Args:
        old: a store of schema version 3 to 6.
        new: the target; it is created, or completed after an interrupted migration.
        progress: called with the number of episodes that are done, and the total.

    Returns:
        The number of episodes.

    Raises:
        StoreError: the old file is no such store, or its episodes and turns disagree.
    """
    if not old.is_file():
        raise StoreError(f"there is no file {old}; give a store of an earlier release")
    with reading(old) as db, Store(new) as store:
        db.row_factory = sqlite3.Row
        try:
            (version,) = db.execute("PRAGMA user_version").fetchone()
            if version not in _COPIES:
                raise StoreError(
                    f"{old} has schema version {version}; only versions {', '.join(map(str, _COPIES))} can be migrated "
                    f"to {SCHEMA_VERSION}"
                )
            facts = {name: json.loads(value) for name, value in db.execute("SELECT name, value FROM manifest")}
            spent = {name: facts.pop(name) for name in ("llm",) if name in facts}
            if "study" in facts and version < 5:  # later ones have definitions of their own
                table = "episode" if version == 3 else "setting"
                rows = db.execute(f"SELECT family, version, rules FROM {table} ORDER BY version, rules")  # noqa: S608
                facts["played"] = {family: played for family, *played in rows}
                store.define(facts)
            store.write_manifest(facts | spent)
            total = db.execute("SELECT count(*) FROM episode").fetchone()[0]
            for done, _ in enumerate(_COPIES[version](db, store), 1):
                if progress:
                    progress(done, total)
        except (sqlite3.DatabaseError, zlib.error) as error:
            raise StoreError(f"cannot read {old}: {error}") from None
        return store.count


def _copy_3(db: sqlite3.Connection, store: Store) -> Iterator[None]:
    """Copy a store that has a row for each turn; stops after each episode."""
    for row in db.execute("SELECT * FROM episode ORDER BY key"):
        store.add(_record(db, row))
        yield


def _copy_4(db: sqlite3.Connection, store: Store) -> Iterator[None]:
    """Copy a store without revisions and seals; stops after each episode."""
    for row in db.execute(f"SELECT *, lower(hex(key)) AS name FROM {_JOINED} ORDER BY number"):  # noqa: S608
        _add(store, row)
        yield
    _copy_failures(db, store)


def _copy_5(db: sqlite3.Connection, store: Store) -> Iterator[None]:
    """Copy a store without the columns of how much claims say, or of what was read; stops after each episode."""
    newest = store.manifest()
    facts = db.execute("SELECT revision, facts FROM definition ORDER BY revision").fetchall()
    revisions = {0: 0, **{revision: store.define(json.loads(text)) for revision, text in facts}}
    store.write_manifest(newest)
    (rows,) = db.execute("SELECT rows FROM seal WHERE sealed = 'result'").fetchone()
    if db.execute(f"SELECT count(*) FROM {_JOINED}").fetchone()[0] != rows:  # noqa: S608
        raise StoreError(f"the store has lost some of its {rows} episodes")
    names = [name for name, *_ in db.execute("SELECT * FROM episode LIMIT 0").description[1:-1]]
    for row in db.execute(f"SELECT *, lower(hex(key)) AS name FROM {_JOINED} ORDER BY number"):  # noqa: S608
        if digest_of((row["name"], row["revision"], *(row[name] for name in names)), row["packed"]) != row["digest"]:
            raise StoreError(f"the episode {row['name']} differs from its digest")
        store.revision = revisions[row["revision"]]
        _add(store, row)
        yield
    _copy_failures(db, store)


def _add(store: Store, row: sqlite3.Row) -> None:
    """Add an episode as an older store has it."""
    spec, episode = _known(EpisodeSpec, row), _known(EpisodeRow, row)
    turns = unpack_turns(row["packed"])
    if spec.key != row["name"] or len(turns) != episode.turns + 1:
        raise StoreError(f"the episode {row['name']} is incomplete, or its key is not that of {spec}")
    sums = {name: sum(turn[name] or 0 for turn in turns) for name in ("unbuilt", "withheld")}
    store.add_packed(spec, episode._replace(**sums), row["packed"])


def _copy_failures(db: sqlite3.Connection, store: Store) -> None:
    for row in db.execute("SELECT * FROM failure"):
        store.add_failure(_known(EpisodeSpec, row), _known(Failure, row))


def _known(kind: Any, row: sqlite3.Row) -> Any:
    """A named tuple of the columns that a row has; those that are newer have their defaults."""
    return kind(**{name: row[name] for name in row.keys() if name in kind._fields})  # noqa: SIM118 (no dict)


def _record(db: sqlite3.Connection, row: sqlite3.Row) -> Record:
    spec = EpisodeSpec(**{name: row[name] for name in EpisodeSpec._fields if name in row.keys()})  # noqa: SIM118
    found = db.execute("SELECT * FROM turn WHERE episode = ? ORDER BY turn", (row["key"],))
    turns = tuple(
        TurnRow(*turn)._replace(success=bool(turn[_SUCCESS]), atoms=json.loads(turn[_ATOMS])) for _, *turn in found
    )
    if spec.key != row["key"] or len(turns) != row["turns"] + 1:
        raise StoreError(f"the episode {row['key']} is incomplete, or its key is not that of {spec}")
    sums = summary(row["family"], row["reads"], turns)
    totals = {name: row[name] for name in ("total_reward", "regret")}
    if differing := [name for name in _CHECKED if getattr(sums, name) != row[name]]:
        raise StoreError(f"the turns of the episode {row['key']} disagree with its {', '.join(differing)}")
    return Record(spec, EpisodeRow(**(sums._asdict() | totals)), turns)


_COPIES = {3: _copy_3, 4: _copy_4, 5: _copy_5, 6: _copy_5}
