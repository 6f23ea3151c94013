"""The store: what it refuses, what it keeps, and what it finds."""

import contextlib
import gc
import json
import sqlite3
import struct
import sys
import threading

import numpy as np
import pytest
from studying import small

from llf_teacher.models.cache import Cache
from llf_teacher.registry import entry
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.database import SCHEMA_VERSION


@pytest.mark.smoke
@pytest.mark.parametrize("database", [Store, lambda path: Cache(f"{path}")], ids=["store", "cache"])
def test_a_database_may_be_collected_in_any_thread(tmp_path, monkeypatch, database):
    unraisable = []
    monkeypatch.setattr(sys, "unraisablehook", unraisable.append)
    held = [database(tmp_path / "it.db")]
    thread = threading.Thread(target=held.clear)
    thread.start()
    thread.join()
    gc.collect()
    assert not held
    assert not unraisable


@pytest.mark.parametrize("version", [3, SCHEMA_VERSION - 1, SCHEMA_VERSION + 1])
def test_a_store_of_another_version_is_refused_and_unchanged(tmp_path, version):
    path = tmp_path / "s.db"
    Store(path).close()
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute(f"PRAGMA user_version = {version}")
    db.close()
    before = path.read_bytes()
    said = f"of schema version {version}, and must be of version {SCHEMA_VERSION}; play the study again, and give"
    for read_only in (False, True):
        with pytest.raises(StoreError, match=said):
            Store(path, read_only=read_only)
    assert path.read_bytes() == before


def test_a_store_that_nobody_closes_is_closed(tmp_path, monkeypatch):
    """Newer Pythons warn of those that are not."""
    opened, connect = [], sqlite3.connect

    def noted(*args, **options):
        opened.append(connect(*args, **options))
        return opened[-1]

    monkeypatch.setattr(sqlite3, "connect", noted)
    Store(tmp_path / "s.db")
    gc.collect()
    (db,) = opened
    with pytest.raises(sqlite3.ProgrammingError, match="closed database"):
        db.execute("SELECT 1")


def test_a_database_of_something_else_is_refused_and_unchanged(tmp_path):
    path = tmp_path / "s.db"
    with contextlib.closing(sqlite3.connect(path)) as db, db:
        db.execute("CREATE TABLE mine (x)")
    db.close()
    before = path.read_bytes()
    with pytest.raises(StoreError, match="another kind of database"):
        Store(path)
    assert path.read_bytes() == before


def test_a_file_that_is_no_database_is_refused_and_unchanged(tmp_path):
    path = tmp_path / "s.db"
    path.write_text("This is not a database, but long enough to look like one. " * 20)
    with pytest.raises(StoreError, match=r"cannot use .*s\.db as a store"):
        Store(path)
    assert path.read_text().startswith("This is not")


@pytest.mark.parametrize("folder", ["none", "/proc"])
def test_a_folder_that_cannot_be_written(tmp_path, folder):
    """One that is not there, and one that nobody may write to, not even root."""
    with pytest.raises(StoreError, match=r"cannot use .*take it by --store"):
        Store(tmp_path / folder / "s.db")


def test_an_episode_is_written_whole_or_not_at_all(tmp_path):
    record = play(next(small().episodes()))
    path = tmp_path / "s.db"
    with Store(path) as store, contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.execute("CREATE TRIGGER full BEFORE INSERT ON story BEGIN SELECT RAISE(ABORT, 'disk full'); END")
        with pytest.raises(sqlite3.IntegrityError, match="disk full"):
            store.add(record)
        assert store.keys() == set()
        assert db.execute("SELECT count(*) FROM setting").fetchone() == (0,)
        db.execute("DROP TRIGGER full")
        store.add(record)
        store.add(record)
        assert store.keys() == {record.spec.key}
        store.check()


def test_turns_are_kept_as_they_were(tmp_path):
    record = play(next(small(ids=["llf-reco-movie-v0"]).episodes()))
    with Store(tmp_path / "s.db") as store:
        store.add(record)
        turns = store.turns(record.spec.key)
    for kept, turn in zip(turns, record.turns, strict=True):
        action = None if turn.action is None else json.loads(turn.action)
        assert kept == turn._asdict() | {"action": action}


def test_every_flipped_bit_is_found(tmp_path):
    """In what is written of an episode; what lies in no row is nobody's."""
    path = tmp_path / "s.db"
    with Store(path) as store:
        for spec in small(seeds=1).episodes():
            store.add(play(spec))
    rng = np.random.default_rng(0)
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        columns = [
            (table, column[1])
            for table in ("setting", "result", "story")
            for column in db.execute(f"PRAGMA table_info({table})").fetchall()
            if not column[5] and column[1] != "setting"
        ]
        for table, column in columns:
            rowid, value = db.execute(f"SELECT rowid, {column} FROM {table} ORDER BY random() LIMIT 1").fetchone()
            db.execute(f"UPDATE OR IGNORE {table} SET {column} = ? WHERE rowid = ?", (flipped(value, rng), rowid))
            with Store(path) as store:
                assert list(store.damage()), (table, column)
            db.execute(f"UPDATE {table} SET {column} = ? WHERE rowid = ?", (value, rowid))
    with Store(path) as store:
        assert not list(store.damage())


def flipped(value, rng):
    """The value with one bit changed."""
    if value is None:
        return 1
    if isinstance(value, int):
        return value ^ (1 << int(rng.integers(5)))
    if isinstance(value, float):
        return struct.unpack("<d", flipped(struct.pack("<d", value), rng))[0]
    data = bytearray(value.encode() if isinstance(value, str) else value) or bytearray(1)
    data[int(rng.integers(len(data)))] ^= 1
    return data.decode() if isinstance(value, str) else bytes(data)


def test_atoms_are_stored_typed(tmp_path):
    record = play(next(small().episodes()))
    atom = record.turns[1].atoms[0]
    assert set(atom) == {"kind", "claim", "fields", "action", "text", "about_turn", "holds", "label"}
    assert atom["holds"] is True
    assert atom["label"] == "truthful"


def test_claims_are_stored_with_whose_they_are():
    """Two classes may have the same name, as long as they are not of the same family."""

    def said(teacher):
        turns = play(next(small(teachers=[teacher]).episodes())).turns
        return [atom for turn in turns for atom in turn.atoms if atom["kind"] is not None]

    of_family, of_all = said("oracle"), said("verification")
    family = entry(small().ids[0]).family.name
    assert {atom["claim"].partition(".")[0] for atom in of_family} == {family, "common"}
    judged = [atom for atom in of_all if atom["claim"] in ("common.Right", "common.Wrong")]
    assert judged
    assert all(atom["action"] == atom["fields"]["action"] for atom in judged)
