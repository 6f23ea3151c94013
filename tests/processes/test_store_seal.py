"""A store says when it is not whole: copies without their log, flipped bits, rows that are gone; archives are whole."""

import contextlib
import itertools
import json
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from commands import llf, llf_apart
from design import amount
from studying import rows, small

from llf_teacher.studies import load
from llf_teacher.studies.definition.study import Study, load_study, quickstart
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, parse_shard, play_missing
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.merging import merge

HERE = RunOptions("here")


def played(path, study):
    with Store(path) as store:
        play_missing(study, store, options=HERE)
    return path


@pytest.fixture(scope="module")
def once_killed(tmp_path_factory):
    """The folder of a store whose writer was killed after its episodes were written."""
    path = tmp_path_factory.mktemp("killed") / "s.db"
    code = (
        "import os, sys; from studying import small; from llf_teacher.studies.store import Store\n"
        "from llf_teacher.studies.execution.episode import play\n"
        "store = Store(sys.argv[1])\n"
        "for spec in small().episodes(): store.add(play(spec))\n"
        f"os.kill(os.getpid(), {signal.SIGKILL:d})"
    )
    environment = {"PYTHONPATH": ":".join(sys.path)}
    assert subprocess.run([sys.executable, "-c", code, str(path)], check=False, env=environment).returncode < 0
    return path.parent


@pytest.fixture
def killed(once_killed, tmp_path):
    """A store whose writer was killed after its episodes were written, and how many there are."""
    return shutil.copytree(once_killed, tmp_path / "killed") / "s.db", len(list(small().episodes()))


def test_a_killed_run_leaves_a_whole_store(killed):
    path, episodes = killed
    result = llf("study", "check", path)
    assert (result.returncode, result.stdout) == (0, f"{episodes} episodes, all as they were written.\n")
    with Store(path) as store:
        assert store.count == episodes
    assert [file.name for file in path.parent.iterdir()] == ["s.db"], "its log is in it"
    assert llf("study", "check", path).returncode == 0


def test_a_copy_without_the_log_says_so(killed, tmp_path):
    copy = shutil.copy(killed[0], tmp_path / "backup.db")
    result = llf("study", "check", copy)
    assert result.returncode == 1
    assert "backup.db, file, row 0: episodes may be missing: it was copied without its log, backup.db-wal" in (
        result.stderr
    )


READERS = {
    "export": ("export", "{store}", "{folder}/a.csv"),
    "turns": ("export", "{store}", "{folder}/a.jsonl", "--turns"),
    "chat": ("export", "{store}", "{folder}/a.jsonl", "--format", "chat"),
    "report": ("report", "--store", "{store}", "--report", "{folder}/a.html"),
    "figures": ("figures", "{folder}/figures", "--store", "{store}"),
    "archive": ("archive", "{store}", "{folder}/a.zip"),
    "diff": ("diff", "{store}", "{store}"),
    "power": ("power", "{store}", "--effect", "0.5"),
    "transcript": ("transcript", "{store}", "0"),
    "merge": ("merge", "{folder}/m.db", "{store}"),
    "check": ("check", "{store}"),
}
"""Every command that reads a store."""


def read_by(name, store, folder):
    return llf("study", *(word.format(store=store, folder=folder) for word in READERS[name]))


def test_all_readers_are_tried():
    listed = re.findall(
        r"^\W*(\w+)  +\w", llf("study", "--help").stdout.partition("Commands")[2].partition("\u2570")[0], re.MULTILINE
    )
    assert set(listed) - {"run", "rescue"} == {command for command, *_ in READERS.values()}


def copied_without_log(live, copy):
    shutil.copy(live, copy)


def copied_with_a_cut_log(live, copy, at=slice(-20_000)):
    shutil.copy(live, copy)
    copy.with_name(f"{copy.name}-wal").write_bytes(live.with_name(f"{live.name}-wal").read_bytes()[at])


def copied_with_an_empty_log(live, copy):
    copied_with_a_cut_log(live, copy, slice(0))


def copied_with_half_a_transaction(live, copy):
    copied_with_a_cut_log(live, copy, slice(32 + 16_408))


def copied_with_a_cut_log_and_its_index(live, copy):
    copied_with_a_cut_log(live, copy)
    shutil.copy(live.with_name(f"{live.name}-shm"), copy.with_name(f"{copy.name}-shm"))


@pytest.mark.parametrize(
    "harm",
    [
        copied_without_log,
        copied_with_a_cut_log,
        copied_with_an_empty_log,
        copied_with_half_a_transaction,
        copied_with_a_cut_log_and_its_index,
    ],
)
def test_a_copy_that_lacks_its_log_or_the_end_of_it_is_read_by_nobody(killed, tmp_path, harm):
    copy = tmp_path / "backup.db"
    harm(killed[0], copy)
    before = {path: path.read_bytes() for path in tmp_path.glob("backup.db*")}
    for name in READERS:
        result = read_by(name, copy, tmp_path)
        assert result.returncode == (1 if name == "check" else 2), (name, result.stderr)
        assert "backup.db" in result.stderr
        assert "episodes may be missing" in result.stderr
        assert {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()} == before, name


def test_a_run_plays_again_what_a_cut_log_had(killed, tmp_path):
    copied_with_a_cut_log(killed[0], tmp_path / "backup.db")
    with Store(tmp_path / "backup.db") as store:
        assert play_missing(small(), store, options=HERE) > 0
        assert store.count == killed[1]
    assert read_by("export", tmp_path / "backup.db", tmp_path).returncode == 0


@pytest.fixture(scope="module")
def torn(tmp_path_factory):
    """The file of a store from before a checkpoint, with the log from after it: `cp` of a live store, one by one."""
    folder = tmp_path_factory.mktemp("torn")
    study = small(seeds=12)
    records = list(map(play, study.episodes()))
    with Store(folder / "live.db") as store:
        store.define({"study": study.as_dict()})
        for record in records[:40]:
            store.add(record)
        shutil.copy(folder / "live.db", folder / "early.db")
        for record in records[40:60]:
            store.add(record)
        store._db.execute("PRAGMA wal_checkpoint(RESTART)")
        shutil.copy(folder / "live.db", folder / "late.db")
        for record in records[60:]:
            store.add(record)
        shutil.copy(folder / "live.db-wal", folder / "early.db-wal")
        shutil.copy(folder / "live.db-wal", folder / "late.db-wal")
        read_live = read_by("export", folder / "live.db", folder)
        assert read_live.stdout.startswith(f"{len(records)} rows"), read_live.stderr
    return folder


def test_a_torn_copy_is_read_by_nobody(torn, tmp_path):
    shutil.copy(torn / "early.db", tmp_path / "copy.db")
    shutil.copy(torn / "early.db-wal", tmp_path / "copy.db-wal")
    for name in READERS:
        result = read_by(name, tmp_path / "copy.db", tmp_path)
        assert result.returncode == (1 if name == "check" else 2), (name, result.stdout)
        assert "copy.db" in result.stderr


def test_a_run_refuses_a_torn_copy_and_leaves_it_as_it_is(torn, tmp_path):
    for end in ("", "-wal"):
        shutil.copy(torn / f"early.db{end}", tmp_path / f"copy.db{end}")
    with pytest.raises(StoreError, match=r"copy\.db is incomplete or damaged: "), Store(tmp_path / "copy.db"):
        pass
    for end in ("", "-wal"):
        assert (tmp_path / f"copy.db{end}").read_bytes() == (torn / f"early.db{end}").read_bytes()


def test_a_copy_of_file_and_log_after_a_checkpoint_is_whole(torn, tmp_path):
    assert read_by("export", torn / "late.db", tmp_path).stdout.startswith("96 rows")


def test_an_archive_of_a_store_that_is_written_to_is_whole(tmp_path):
    path, study, counts = tmp_path / "s.db", small(), []
    moments = amount((5,), full=(5, 11))

    def progress(done, total):
        if done in moments:
            archive = tmp_path / f"{done}.zip"
            result = llf("study", "archive", path, archive)
            assert result.stdout == f"Archive: {archive}\n", result.stderr
            with zipfile.ZipFile(archive) as opened:
                opened.extractall(tmp_path / f"{done}")
            with Store(path, read_only=True) as live:
                counts.append((tmp_path / f"{done}", live.count))

    with Store(path) as store:
        play_missing(study, store, options=HERE, progress=progress)
    assert len(counts) == len(moments)
    for folder, count in counts:
        assert llf("study", "check", folder / "study.db").stdout == f"{count} episodes, all as they were written.\n"
        assert load_study(folder / "study.toml") == study
        assert json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["study"] == study.as_dict()
        assert "llf-teacher==" in (folder / "requirements.txt").read_text(encoding="utf-8")
        assert "<html" in (folder / "report.html").read_text(encoding="utf-8")
        with Store(folder / "study.db") as copy:
            assert play_missing(study, copy, options=HERE) == len(list(study.episodes())) - count
        assert rows(folder / "study.db") == rows(path)


def test_reading_leaves_no_trace(tmp_path):
    """So that a store can be read where nothing can be written."""
    path = played(tmp_path / "s.db", small(seeds=1))
    before = path.read_bytes()
    for command in (("check",), ("export",)):
        more = [tmp_path.parent / f"{tmp_path.name}.csv"] if command == ("export",) else []
        assert llf("study", *command, path, *more).returncode == 0
    with load(path) as results:
        assert results.report().html
    assert [file.name for file in tmp_path.iterdir()] == ["s.db"]
    assert path.read_bytes() == before
    with Store(path, read_only=True) as store, pytest.raises(StoreError, match="cannot write to"):
        store.write_manifest({"a": 1})


@pytest.mark.parametrize(
    ("harm", "where"),
    [
        ("UPDATE manifest SET value = replace(value, 'oracle', 'Oracle') WHERE name = 'study'", "manifest, row study"),
        ("UPDATE manifest SET value = x'ff' WHERE name = 'versions'", "manifest, row versions"),
        ("DELETE FROM manifest WHERE name = 'python'", "seal, row manifest"),
        ("UPDATE definition SET facts = replace(facts, 'oracle', 'Oracle')", "definition, row 1"),
        ("UPDATE failure SET trace = CAST(x'ff' AS TEXT) WHERE number = 1", "failure, row 1"),
        ("DELETE FROM failure", "seal, row failure"),
        ("UPDATE story SET packed = 'text' WHERE number = 2", "result, row 2"),
        ("UPDATE story SET packed = 7 WHERE number = 2", "result, row 2"),
        ("DELETE FROM result WHERE number = 2", "story, row 2"),
        ("DELETE FROM story WHERE number = 2; DELETE FROM result WHERE number = 2", "seal, row result"),
        ("UPDATE result SET revision = 7 WHERE number = 3", "result, row 3"),
        ("DELETE FROM setting WHERE setting = 1", "result, row 1"),
        ("UPDATE seal SET rows = rows + 1 WHERE sealed = 'result'", "seal, row result"),
        ("DELETE FROM seal", "seal, row failure"),
    ],
)
def test_what_is_changed_or_gone_is_named(tmp_path, monkeypatch, harm, where):
    (tmp_path / "breaks.py").write_text(
        "class Breaks:\n    def act(self, observation):\n        raise KeyError('no')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "s.db"
    with Store(path) as store, pytest.raises(EpisodeError):
        play_missing(small(seeds=1, students=["random", "breaks:Breaks"]), store, options=HERE)
    assert llf("study", "check", path).returncode == 0
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.executescript(harm)
    result = llf("study", "check", path)
    assert result.returncode == 1
    assert f"s.db, {where}: " in result.stderr


def test_a_store_that_lacks_a_row_is_read_by_nobody(tmp_path):
    path = played(tmp_path / "s.db", small(seeds=1))
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.executescript("DELETE FROM story WHERE number = 2; DELETE FROM result WHERE number = 2")
    for name in READERS:
        result = read_by(name, path, tmp_path)
        assert result.returncode == (1 if name == "check" else 2), (name, result.stdout)
        assert re.search(r"s\.db.* the table result has 7 rows instead of 8", result.stderr)


def test_a_store_with_a_changed_value_is_read_by_nobody_and_rescued(tmp_path):
    path, new, again = played(tmp_path / "s.db", small(seeds=1)), tmp_path / "new.db", tmp_path / "again.db"
    untouched = llf("study", "export", path, tmp_path / "untouched.csv")
    assert untouched.returncode == 0
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.executescript(
            "UPDATE result SET regret = regret + 1 WHERE number = 3; UPDATE story SET packed = x'00' WHERE number = 5"
        )
    for name in READERS:
        result = read_by(name, path, tmp_path)
        assert result.returncode == (1 if name == "check" else 2), (name, result.stdout)
        assert re.search(r"s\.db.*result, row 3|s\.db.*row 3", result.stderr)
    before = path.read_bytes()
    result = llf("study", "rescue", path, new)
    assert (result.returncode, path.read_bytes()) == (0, before), result.stderr
    assert "6 of 8 episodes" in result.stdout
    assert llf("study", "check", new).returncode == 0
    assert "exists; give a file" in llf("study", "rescue", path, new).stderr
    played(new, small(seeds=1))
    assert rows(new) == rows(played(again, small(seeds=1)))


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.full) for seed in (1, 2))])
def test_what_is_rescued_is_whole(tmp_path, seed):
    """Zeroed pages and cut ends lose episodes, and never change one."""
    path, harmed = played(tmp_path / "s.db", small(seeds=2)), tmp_path / "harmed.db"
    data, rng, good, saved = path.read_bytes(), np.random.default_rng(seed), rows(path), 0
    for number in range(12):
        bad, place = bytearray(data), int(rng.integers(16_384, len(data)))
        bad[place:] = b"" if number % 2 else bytes(4096) + bad[place + 4096 :]
        harmed.write_bytes(bad)
        new = tmp_path / f"{number}.db"
        result = llf("study", "rescue", harmed, new)
        assert "Traceback" not in result.stderr
        assert result.returncode in (0, 2)
        if result.returncode:
            assert "harmed.db" in result.stderr
            assert not new.exists()
        else:
            assert all(row in known for found, known in zip(rows(new), good, strict=True) for row in found)
            saved += 1
    assert saved > 0


def test_a_flipped_bit_in_the_schema_has_the_name_of_its_file(tmp_path):
    path, flipped = played(tmp_path / "s.db", small(seeds=1)), tmp_path / "flipped.db"
    data = path.read_bytes()
    places = [data.index(word) + 1 for word in (b"CREATE TABLE result", b"setting INTEGER", b"seal (sealed", b"VIEW")]
    for place, name in itertools.product(places, READERS):
        flipped.write_bytes(data[:place] + bytes([data[place] ^ 0x80]) + data[place + 1 :])  # no UTF-8
        result = read_by(name, flipped, tmp_path)
        assert result.returncode == 2, (place, name)
        assert "flipped.db" in result.stderr
        assert "Traceback" not in result.stderr


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.full) for seed in (1, 2))])
def test_no_flipped_bit_is_silent_or_a_traceback(tmp_path, seed):
    path, flipped = played(tmp_path / "s.db", small(seeds=1)), tmp_path / "flipped.db"
    data, content, rng = path.read_bytes(), everything(path), np.random.default_rng(seed)
    found = 0
    for _ in range(40):
        harmed, place = bytearray(data), int(rng.integers(len(data)))
        harmed[place] ^= 1 << int(rng.integers(8))
        flipped.write_bytes(harmed)
        changed = everything(flipped) != content
        result = llf("study", "check", flipped)
        assert result.returncode in ((1, 2) if changed else (0, 1, 2)), (place, result.stderr)
        assert "Traceback" not in result.stderr
        assert (result.returncode > 0) == ("flipped.db" in result.stderr)
        found += changed
    assert found > 0


def everything(path):
    """All rows of all tables; None if they cannot be read."""
    with contextlib.closing(sqlite3.connect(path)) as db:
        db.text_factory = bytes
        try:
            tables = [name.decode() for (name,) in db.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")]
            contents = [db.execute(f'SELECT * FROM "{name}"').fetchall() for name in sorted(tables)]
            return repr((db.execute("SELECT type, name, sql FROM sqlite_schema").fetchall(), contents))
        except (sqlite3.Error, UnicodeError):
            return None


def test_an_edited_study_keeps_its_old_definition(tmp_path):
    path, first, second = tmp_path / "s.db", small(seeds=1), small(seeds=2)
    for study in (first, second, second):
        played(path, study)
    with load(path) as results:
        assert [facts["study"]["seeds"] for facts in results.definitions.values()] == [[0], [0, 1]]
        revisions = {row["seed"]: row["revision"] for row in results.rows()}
        assert results.study == second
    assert revisions == {0: 1, 1: 2}
    played(path, first)
    with load(path) as results:
        assert list(results.definitions) == [1, 2]
        assert results.study == first


def test_a_shard_of_another_study_is_refused_and_leaves_nothing(tmp_path):
    parts = [tmp_path / "a.db", tmp_path / "b.db"]
    for number, (path, study) in enumerate(zip(parts, (small(), small(seeds=3)), strict=True), 1):
        with Store(path) as store:
            play_missing(study, store, options=RunOptions("here", shard=parse_shard(f"{number}/2")))
    with pytest.raises(StoreError, match=r"b\.db is of another study than .*a\.db: they differ in seeds; merge"):
        merge(tmp_path / "c.db", parts)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.db", "b.db"]
    before = parts[0].read_bytes()
    with pytest.raises(StoreError, match="differ in seeds"):
        merge(parts[0], parts[1:])
    assert parts[0].read_bytes() == before


def test_merged_rows_keep_their_definitions(tmp_path):
    path = tmp_path / "s.db"
    for study in (small(seeds=1), small(seeds=2)):
        played(path, study)
    with Store(path) as store:
        store.add(play(next(small(seeds=[9]).episodes())))
    merge(tmp_path / "merged.db", [path])
    with load(path) as results, load(tmp_path / "merged.db") as merged:
        assert list(merged.rows()) == list(results.rows())
        assert merged.definitions == results.definitions
        assert merged.manifest == results.manifest


@pytest.mark.parametrize(
    "study",
    [
        small(),
        quickstart(),
        small(
            feedback_types="subsets",
            interim_analyses={"at": [1, 2], "stop": True},
            transfer={"lessons": [2], "students": ["text_only(forget=False)"]},
            fewer={"llf-bandits*": {"seeds": [0]}},
            transcripts=[{"id": "llf-*", "seeds": [0]}],
            names={"random": "dice"},
        ),
    ],
)
def test_a_recalled_study_is_the_study(study):
    recalled = Study.from_manifest({"study": study.as_dict()})
    assert recalled == study
    assert list(recalled.episodes()) == list(study.episodes())


OWN = """
from teachers.personality import personality


class Blind:
    reads = "nothing"

    def act(self, observation):
        return "north"


class Reader:
    def act(self, observation):
        return "south"


@personality(mute=True)
def shy(claims, view):
    return ()
"""


def test_a_report_needs_nobody_s_own_code(tmp_path):
    home, away = tmp_path / "home", tmp_path / "away"
    home.mkdir()
    away.mkdir()
    (home / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle", "mine:shy", "silent"]\n'
        'students = ["mine:Blind", "mine:Reader"]\nseeds = 5\nmax_turns = 3\n'
    )
    (home / "mine.py").write_text(OWN)
    played = llf_apart("study", "run", "study.toml", "--workers", "1", "--store", "s.db", cwd=home)
    assert played.returncode == 0, played.stderr
    pages = []
    for folder, store in ((home, "s.db"), (away, "../home/s.db")):
        commands = (
            ("report", "--store", store, "--report", "r.html"),
            ("check", store),
            ("export", store, "e.csv"),
            ("figures", "figures", "--store", store),
            ("archive", store, "a.zip"),
            ("diff", store, store),
        )
        for command in commands[: None if folder == away else amount(1, full=None)]:
            apart = folder == away and command[0] == "report"  # a process of its own has imported nothing
            result = (llf_apart if apart else llf)("study", *command, cwd=folder)
            assert result.returncode == 0, (command, result.stderr)
        pages.append((folder / "r.html").read_text(encoding="utf-8"))
        (home / "mine.py").unlink(missing_ok=True)
    assert pages[0] == pages[1]
    assert "reads nothing" in pages[1]


def test_a_store_of_another_release_has_its_report(tmp_path, monkeypatch):
    """The versions are part of what identifies an episode."""
    path = tmp_path / "s.db"
    with monkeypatch.context() as patched:
        patched.setattr("llf_teacher.__version__", "0.0.9")
        played(path, small())
    result = llf("study", "report", "--store", path, "--report", tmp_path / "r.html")
    assert result.returncode == 0, result.stderr
    with load(path) as results:
        assert {spec.version.partition("+")[0] for spec in results.played_study.episodes()} == {"0.0.9"}
        assert "16 of 16 episodes played" in results.report().html
        with pytest.raises(ValueError, match=r"holds no episode of this study; run it first. The store has 16 others"):
            results.report(results.study)


def test_a_report_names_episodes_of_other_definitions(tmp_path):
    path = tmp_path / "s.db"
    for study in (small(seeds=[5, 6]), small(seeds=[6, 7], teachers=["oracle"])):
        played(path, study)
    with load(path) as results:
        table = (
            results.report().html.partition("Definitions with which this store was run.")[2].partition("</table>")[0]
        )
    cells = re.findall(r"<t[dh][^>]*>([^<]*)</t[dh]>", table.partition("<tbody>")[2])
    assert cells == ["1", "teachers, seeds", "4", "12", "2", "nothing", "4", "0"]
    with load(played(tmp_path / "one.db", small())) as results:
        assert "Definitions with which this store was run" not in results.report().html
