"""A store that is gone, full, or somebody else's; parts of a study, and a report at any time."""

import contextlib
import shutil
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from commands import llf, llf_apart
from design import amount
from studying import FILE, rows

from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, Shard, StudyError, parse_shard, play_missing
from llf_teacher.studies.store import Store, StoreError
from llf_teacher.studies.store.merging import merge
from llf_teacher.studies.store.store_lock import lock_store

HERE = RunOptions("here")
STOP = "class Breaks:\n    def act(self, observation):\n        raise KeyError('no idea')\n"


def study(**changes):
    settings = {
        "ids": ["llf-gridworld-v0", "llf-bandits-BanditTwoArmedHighLowFixed-v0"],
        "teachers": ["oracle", "silent"],
        "students": ["random"],
        "seeds": 4,
        "max_turns": 3,
    }
    return Study(**settings | changes)


def content(path):
    """Episodes and turns, whatever the order in which they were written."""
    with contextlib.closing(sqlite3.connect(path)) as db:
        packed = "SELECT key, packed FROM result JOIN story USING (number) ORDER BY key"
        return [db.execute(query).fetchall() for query in ("SELECT * FROM episode ORDER BY key", packed)]


def move(path):
    path.rename(path.with_name("elsewhere.db"))


def replace(path):
    shutil.copy(path, path.with_name("copy.db"))
    path.with_name("copy.db").replace(path)


@pytest.mark.parametrize("harm", [lambda path: path.unlink(), move, replace], ids=["deleted", "moved", "replaced"])
def test_a_store_that_is_gone_is_noticed(tmp_path, harm):
    path = tmp_path / "s.db"

    def progress(done, total):
        if done == 3:
            harm(path)

    with pytest.raises(StoreError, match=r"s\.db was deleted, moved or replaced while it was in use"), Store(path) as s:
        play_missing(study(), s, options=HERE, progress=progress)
    if harm is move:
        move_back = tmp_path / "elsewhere.db"
        move_back.rename(path)
        with Store(path) as store:
            assert play_missing(study(), store, options=HERE) == 13
    if harm is replace:
        assert path.exists(), "what is not ours is left alone"


def test_the_command_line_says_that_a_store_is_gone(tmp_path):
    (tmp_path / "thief.py").write_text(
        "import os\n\n\nclass Thief:\n    def act(self, observation):\n"
        "        if os.path.exists('s.db'):\n            os.remove('s.db')\n        return 'north'\n"
    )
    (tmp_path / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nstudents = ["thief:Thief"]\nseeds = 2\n'
    )
    result = llf_apart("study", "run", "study.toml", "--store", "s.db", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 2
    assert result.stderr.startswith("llf: s.db was deleted, moved or replaced")
    assert "stored in" not in result.stderr


def test_a_full_disk_is_said_and_what_was_written_stays(tmp_path):
    with Store(tmp_path / "s.db") as store:
        pages = store._db.execute("PRAGMA page_count").fetchone()[0]
        store._db.execute(f"PRAGMA max_page_count = {pages + 2}")
        with pytest.raises(StoreError, match=r"^cannot write to .*s\.db: database or disk is full; earlier"):
            play_missing(study(seeds=50), store, options=HERE)
        before = store.count
        assert before > 0
        store._db.execute("PRAGMA max_page_count = 100000")
        assert not list(store.damage())
        assert play_missing(study(seeds=50), store, options=HERE) == 200 - before


def test_a_second_run_on_a_store_is_refused(tmp_path):
    path = tmp_path / "s.db"
    refused = []

    def progress(done, total):
        if done == 2:
            with Store(path) as second, pytest.raises(StoreError, match="another run writes to") as caught:
                play_missing(study(), second, options=HERE)
            refused.append(caught.value)

    with Store(path) as store:
        play_missing(study(), store, options=HERE, progress=progress)
        assert play_missing(study(), store, options=HERE) == 0
    assert len(refused) == 1
    assert [file.name for file in tmp_path.iterdir()] == ["s.db"]


def test_a_link_to_a_store_is_the_store(tmp_path):
    """Its log and its lock lie beside the file that the link points to: read by the link, a live store had no rows."""
    (tmp_path / "disk").mkdir()
    path, link = tmp_path / "disk" / "s.db", tmp_path / "link.db"
    link.symlink_to(path)
    with Store(path) as live, lock_store(path):
        for spec in study().episodes():
            live.add(play(spec))
        assert path.with_name("s.db-wal").exists(), "a writer is at work"
        with Store(link, read_only=True) as seen:
            seen.check()
            assert seen.count == live.count
        with Store(link) as second, pytest.raises(StoreError, match="another run writes to"):
            play_missing(study(), second, options=HERE)
    assert [file.name for file in tmp_path.rglob("*.db*")] == ["link.db", "s.db"]


def test_the_lock_goes_with_its_holder(tmp_path):
    path = tmp_path / "s.db"
    code = (
        "import os, sys; from pathlib import Path; from llf_teacher.studies.store.store_lock import lock_store\n"
        "with lock_store(Path(sys.argv[1])): os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)
    assert path.with_name("s.db-lock").exists()
    with lock_store(path):
        pass
    assert not path.with_name("s.db-lock").exists()


def test_shards_put_together_are_the_study(tmp_path):
    whole, parts = tmp_path / "whole.db", [tmp_path / f"{number}.db" for number in (1, 2, 3)]
    with Store(whole) as store:
        assert play_missing(study(), store, options=HERE) == 16
    played = []
    for number, path in enumerate(parts, 1):
        with Store(path) as store:
            played.append(play_missing(study(), store, options=RunOptions("here", shard=parse_shard(f"{number}/3"))))
    assert played == [6, 5, 5]
    merged = tmp_path / "merged.db"
    result = llf("study", "merge", merged, *parts, parts[0])
    assert result.stdout == f"16 episodes, stored in {merged}.\n", result.stderr
    assert content(merged) == content(whole)
    with Store(merged) as store, Store(whole) as undisturbed:
        assert not list(store.damage())
        assert store.manifest() == undisturbed.manifest()
        assert play_missing(study(), store, options=HERE) == 0


def test_failures_and_expenses_are_put_together(tmp_path, monkeypatch):
    (tmp_path / "breaks.py").write_text(STOP)
    monkeypatch.syspath_prepend(tmp_path)
    fails = study(students=["breaks:Breaks"], seeds=1)
    paths = [tmp_path / "a.db", tmp_path / "b.db"]
    spent = {"model": "m", "requests": 2, "input_tokens": 10, "output_tokens": 20, "usd": 0.5}
    for path in paths:
        with Store(path) as store:
            with pytest.raises(EpisodeError):
                play_missing(fails, store, options=HERE)
            store.write_manifest({"llm": [spent]})
    assert merge(tmp_path / "c.db", paths) == 0
    with Store(tmp_path / "c.db") as store, Store(paths[0]) as part:
        assert list(store.failures()) == list(part.failures())
        assert len(list(store.failures())) == 4
        sums = {"model": "m", "requests": 4, "input_tokens": 20, "output_tokens": 40, "usd": 1.0}
        assert store.manifest()["llm"] == [sums]


def test_a_damaged_part_is_not_taken(tmp_path):
    path = tmp_path / "a.db"
    with Store(path) as store:
        store.add(play(next(study().episodes())))
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.execute("UPDATE result SET words = words + 1")
    with pytest.raises(StoreError, match=r"a\.db, result, row 1: the episode .* differs from its digest"):
        merge(tmp_path / "b.db", [path])
    assert not (tmp_path / "b.db").exists()
    with pytest.raises(StoreError, match="there is no file"):
        merge(tmp_path / "b.db", [tmp_path / "none.db"])
    with pytest.raises(StoreError, match="cannot be a part"):
        merge(path, [path])


@pytest.mark.parametrize("text", ["0/3", "4/3", "3", "a/b", "1/0", "-1/3"])
def test_a_part_that_cannot_be_is_refused(text):
    with pytest.raises(ValueError, match="shard must be i/n with 1 <= i <= n, as in 3/8, got"):
        parse_shard(text)
    assert parse_shard("2/3") == Shard(2, 3)


def test_a_report_may_be_made_at_any_time(tmp_path):
    """Also while the study is played, and without its file."""
    path, page = tmp_path / "s.db", tmp_path / "r.html"
    command = ("study", "report", "--store", path, "--report", page)

    def progress(done, total):
        if done == 9:
            result = llf_apart(*command)
            assert result.returncode == 0, result.stderr
            assert page.exists()
            raise StudyError("stopped")

    with Store(path) as store, pytest.raises(StudyError, match="stopped"):
        play_missing(study(), store, options=HERE, progress=progress)
    page.unlink()
    assert llf(*command).returncode == 0
    assert "<html" in page.read_text(encoding="utf-8")
    result = llf("study", "report", "--store", tmp_path / "none.db")
    assert result.returncode == 2
    assert "there is no file" in result.stderr


def test_a_killed_study_goes_on_to_the_same_rows(tmp_path):
    """SIGKILL in the middle, twice: nothing is lost, nothing is played twice."""
    seeds = amount(24, full=50)
    (tmp_path / "study.toml").write_text(FILE.replace("seeds = 3", f"seeds = {seeds}"))
    command = ("study", "run", "study.toml")
    assert llf(*command, "--executor", "here", "--store", "whole.db", cwd=tmp_path).returncode == 0
    command = (*command, "--workers", "2", "--store", "killed.db")
    apart = [sys.executable, "-m", "llf_teacher", *command]
    counts = []
    for _ in range(2):
        process = subprocess.Popen(apart, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wanted = (counts[-1] if counts else 0) + 20
        while process.poll() is None and _count(tmp_path / "killed.db") < wanted:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.wait()
        counts.append(_count(tmp_path / "killed.db"))
        assert wanted <= counts[-1] < 6 * seeds
    assert llf(*command, cwd=tmp_path).returncode == 0
    assert rows(tmp_path / "killed.db") == rows(tmp_path / "whole.db")
    assert len(rows(tmp_path / "whole.db")[0]) == 6 * seeds


def _count(path):
    if not path.exists():
        return 0
    try:
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as db:
            return db.execute("SELECT count(*) FROM episode").fetchone()[0]
    except sqlite3.OperationalError:  # not written yet
        return 0
