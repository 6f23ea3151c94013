"""Migration of stores of the previous schema version."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path

from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec, Record, TurnRow, summary
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.database import SCHEMA_VERSION, read_only

_OLD = 3
_SUCCESS = TurnRow._fields.index("success")
_CHECKED = ("turns", "success", "first_success", "parse_failures", "claims", "claims_held", "words")


def migrate(old: Path, new: Path, progress: Callable[[int, int], object] | None = None) -> int:
    """Copy the episodes, turns and manifest of an older store into a new one; the old one is only read.

    Args:
        old: a store of schema version 3.
        new: the target; it is created, or completed after an interrupted migration.
        progress: called with the number of episodes that are done, and the total.

    Returns:
        The number of episodes.

    Raises:
        StoreError: the old file is no such store, or its episodes and turns disagree.
    """
    if not old.is_file():
        raise StoreError(f"there is no file {old}; give a store of an earlier release")
    with read_only(old) as db, Store(new) as store:
        db.row_factory = sqlite3.Row
        try:
            (version,) = db.execute("PRAGMA user_version").fetchone()
            if version != _OLD:
                raise StoreError(
                    f"{old} has schema version {version}; only version {_OLD} can be migrated to {SCHEMA_VERSION}"
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
        raise StoreError(f"the episode {row['key']} is incomplete, or its key is not that of {spec}")
    sums = summary(row["family"], row["reads"], turns)
    totals = {name: row[name] for name in ("total_reward", "regret")}
    if differing := [name for name in _CHECKED if getattr(sums, name) != row[name]]:
        raise StoreError(f"the turns of the episode {row['key']} disagree with its {', '.join(differing)}")
    return Record(spec, EpisodeRow(**(sums._asdict() | totals)), turns)
