"""Migration of stores of earlier schema versions."""

import json
import sqlite3
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

from llf_teacher.episodes.failure import Failure
from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, TurnRow, summary, unpack_turns
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.database import SCHEMA_VERSION
from llf_teacher.studies.store.files import reading

_SUCCESS, _ATOMS = map(TurnRow._fields.index, ("success", "atoms"))
_CHECKED = ("turns", "success", "first_success", "parse_failures", "claims", "claims_held", "words")


def migrate(old: Path, new: Path, progress: Callable[[int, int], object] | None = None) -> int:
    """Copy the episodes, turns and manifest of an older store into a new one; the old one is only read.

    Args:
        old: a store of schema version 3 or 4.
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
            facts = {name: json.loads(value) for name, value in db.execute("SELECT * FROM manifest")}
            spent = {name: facts.pop(name) for name in ("llm",) if name in facts}
            if "study" in facts:
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
    spec, row = (", ".join(each._fields) for each in (EpisodeSpec, EpisodeRow))
    joined = "result JOIN setting USING (setting) JOIN story USING (number)"
    size = len(EpisodeSpec._fields)
    for key, packed, *values in db.execute(f"SELECT lower(hex(key)), packed, {spec}, {row} FROM {joined}"):  # noqa: S608
        played = EpisodeSpec(*values[:size])
        if played.key != key or len(unpack_turns(packed)) != values[size + EpisodeRow._fields.index("turns")] + 1:
            raise StoreError(f"the episode {key} is incomplete, or its key is not that of {played}")
        store.add_packed(played, EpisodeRow(*values[size:]), packed)
        yield
    failure = ", ".join(Failure._fields)
    for values in db.execute(f"SELECT {spec}, {failure} FROM failure"):  # noqa: S608
        store.add_failure(EpisodeSpec(*values[:size]), Failure(*values[size:]))


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


_COPIES = {3: _copy_3, 4: _copy_4}
