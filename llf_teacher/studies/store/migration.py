"""Stores of the schema before, read into one of now."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, TurnRow, summary
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.database import SCHEMA_VERSION, read_only

_OLD = 3
_SUCCESS = TurnRow._fields.index("success")
_TOLD = ("turns", "success", "first_success", "parse_failures", "claims", "claims_held", "words")


def migrate(old: Path, new: Path, progress: Callable[[int, int], object] | None = None) -> int:
    """Write every episode of an older store, its turns and the manifest into another file; the old one is only read.

    Args:
        old: a store of schema version 3.
        new: where the episodes go; it is made, or goes on where an earlier migration has stopped.
        progress: called with the number of episodes that are done, and of all.

    Returns:
        The number of episodes.

    Raises:
        StoreError: the old file is no such store, or its episodes do not say what its turns say.
    """
    if not old.is_file():
        raise StoreError(f"there is no file {old}; give a store of an earlier release")
    with read_only(old) as db, Store(new) as store:
        db.row_factory = sqlite3.Row
        try:
            (version,) = db.execute("PRAGMA user_version").fetchone()
            if version != _OLD:
                raise StoreError(
                    f"{old} has schema version {version}; what can be migrated to {SCHEMA_VERSION} is {_OLD}"
                )
            store.write_manifest({name: json.loads(value) for name, value in db.execute("SELECT * FROM manifest")})
            total = db.execute("SELECT count(*) FROM episode").fetchone()[0]
            for done, row in enumerate(db.execute("SELECT * FROM episode ORDER BY key"), 1):
                store.add(_record(db, row))
                if progress:
                    progress(done, total)
        except sqlite3.DatabaseError as error:
            raise StoreError(f"cannot read {old}: {error}") from None
        return store.count


def _record(db: sqlite3.Connection, row: sqlite3.Row) -> Record:
    spec = EpisodeSpec(**{name: row[name] for name in EpisodeSpec._fields if name in row.keys()})  # noqa: SIM118
    found = db.execute("SELECT * FROM turn WHERE episode = ? ORDER BY turn", (row["key"],))
    turns = tuple(TurnRow(*turn)._replace(success=bool(turn[_SUCCESS])) for _, *turn in found)
    if spec.key != row["key"] or len(turns) != row["turns"] + 1:
        raise StoreError(f"of the episode {row['key']} only parts are there, or it is another one than it says: {spec}")
    told = summary(row["family"], row["reads"], turns)
    sums = {name: row[name] for name in ("total_reward", "regret")}
    if differing := [name for name in _TOLD if getattr(told, name) != row[name]]:
        raise StoreError(f"the turns of the episode {row['key']} say otherwise than its {', '.join(differing)}")
    return Record(spec, EpisodeRow(**(told._asdict() | sums)), turns)
