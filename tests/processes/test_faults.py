"""Agents that raise, hang, exit or eat memory fail their episode; the rest goes on, and the rows are the same."""

import contextlib
import io
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path
from types import SimpleNamespace

import faulty
import pytest
from pebble.pool.process import PoolManager
from rich.console import Console

from llf_teacher import studies
from llf_teacher.episodes.failure import REASONS
from llf_teacher.episodes.record import pack_turns, unpack_turns
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution import executors, runner
from llf_teacher.studies.execution import limits as limits_module
from llf_teacher.studies.execution import progress as progress_module
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.progress import StudyProgress
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, play_missing
from llf_teacher.studies.execution.worker import Packed, run_episode
from llf_teacher.studies.store import Store
from llf_teacher.suite import take

PLACE = r" \(faulty\.py, line \d+\)$"
FAULTS = {
    "raises": ("raised", r"^KeyError\('no idea'\)" + PLACE),
    "unspeakable": ("raised", "^Unspeakable" + PLACE),
    "leaves": ("raised", r"^SystemExit\(3\)" + PLACE),
    "sleeps": ("time", "^not over after 5 seconds, in turn 1" + PLACE),
    "deaf": ("time", "^not over after .* seconds, and did not end by itself$"),
    "exits": ("died", "^its process ended with exit status 0$"),
    "eats": ("memory", "^no memory of 400 MB is left: MemoryError"),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where other processes find the agents."""
    monkeypatch.setenv("PYTHONPATH", f"{Path(faulty.__file__).parent}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    return tmp_path


def study(*students, seeds=1, **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle"], "max_turns": 3}
    return Study(**settings | changes, students=students, seeds=seeds)


def rows(store):
    return sorted(tuple(row) for row in store.episodes())


def test_each_fault_fails_its_episode_and_no_other(folder, monkeypatch):
    monkeypatch.setattr(limits_module, "_GRACE", 0.2)
    faults = [f"faulty:Agent(fault='{fault}')" for fault in FAULTS]
    sound = ["random", "faulty:Agent"]
    whole = study(*faults, *sound, seeds=1)
    options = RunOptions(limits=Limits(episode_seconds=5, memory=400))
    with Store(folder / "s.db") as store:
        with pytest.raises(EpisodeError, match=f"^{len(FAULTS)} of {len(FAULTS) + 2} episodes failed, the first: epis"):
            play_missing(whole, store, workers=2, options=options)
        told = {row["student"]: row for row in store.failures()}
        for fault, (reason, error) in FAULTS.items():
            row = told[f"faulty:Agent(fault='{fault}')"]
            assert row["reason"] == reason, row
            assert re.search(error, row["error"]), row
            assert reason in REASONS
            assert ("faulty.py" in row["trace"]) == (fault not in ("deaf", "exits"))
        undisturbed = sorted((spec.key, *spec, *play(spec).episode, 1) for spec in study(*sound).episodes())
        assert rows(store) == undisturbed
        assert not list(store.damage())


def test_of_a_batch_only_that_task_is_lost_that_ends_its_process(folder):
    told, submitted, rooms = {}, 0, []
    with executors.start("processes", executors.Work(int, faulty.square, 100), 2) as engine:
        while len(told) < 100:
            while submitted < min(100, len(told) + engine.room):
                engine.submit(submitted)
                submitted += 1
            rooms.append(engine.room)
            for number, result in engine.wait(1):
                assert number not in told
                told[number] = result
    lost = executors.Lost("died", "its process ended with exit status 0")
    assert told == {number: lost if number in (37, 61) else number**2 for number in range(100)}
    assert max(rooms) > 6 * 2, "short tasks travel together"
    assert rooms[-1] == 6, "the last ones in small company"


def test_no_task_is_lost_with_a_process_that_ends_as_soon_as_it_takes_one(folder, monkeypatch):
    """Where the pool sees its end before it reads which task that was, as on a busy machine, it waited for ever."""
    read = PoolManager.process_next_message

    def late(self, timeout):
        time.sleep(0.4)
        return read(self, timeout)

    monkeypatch.setattr(PoolManager, "process_next_message", late)
    with executors.start("processes", executors.Work(int, faulty.spoil, 4), 2) as engine:
        for number in range(4):
            engine.submit(number)
        found, until = [], time.monotonic() + 120
        while len(found) < 4 and time.monotonic() < until:
            found += engine.wait(1.0)
    assert sorted(found) == [(number, number) for number in range(4)]


def test_failed_episodes_are_played_again_when_asked_for(folder, monkeypatch):
    fails = study("faulty:Agent(fault='raises')", "random")
    with Store(folder / "s.db") as store:
        for match in ("no idea", "^1 of 2 episodes failed in an earlier run, such as .*no idea"):
            with pytest.raises(EpisodeError, match=match) as caught:
                play_missing(fails, store, workers=1, options=RunOptions("here"))
        assert caught.value.played == 0
        monkeypatch.setattr(faulty.Agent, "raises", faulty.Agent.none)
        assert play_missing(fails, store, workers=1, options=RunOptions("here", retry_failed=True)) == 1
        assert not list(store.failures())
        assert store.count == 2
        assert play_missing(fails, store, workers=1) == 0


def test_in_python_a_failure_is_a_warning(folder):
    fails = study("faulty:Agent(fault='raises')", "random")
    with pytest.warns(RuntimeWarning, match="failed: KeyError.*`failures` of the results gives the reasons"):
        results = studies.run(fails, folder / "s.db", options=RunOptions("here"))
    (failed,) = results.failures()
    assert re.search(FAULTS["raises"][1], failed["error"])
    assert [row["student"] for row in results.rows()] == ["random"]


def test_a_failure_is_covered_by_a_digest(folder):
    with Store(folder / "s.db") as store:
        with pytest.raises(EpisodeError):
            play_missing(study("faulty:Agent(fault='raises')"), store, options=RunOptions("here"))
        assert not list(store.damage())
        for change in ("seed = 1", "reason = 'died'", "error = ''", "trace = 'x'", "key = x'00'"):
            store._db.execute("SAVEPOINT before")
            store._db.execute(f"UPDATE failure SET {change}")
            assert [problem for *_, problem in store.damage() if "the failure of" in problem], change
            store._db.execute("ROLLBACK TO before")
            store._db.execute("RELEASE before")


def test_an_agent_that_hangs_is_not_measured(tmp_path):
    with pytest.warns(RuntimeWarning, match="failed"):
        card = take("faulty:Sleepy", tmp_path / "it.db", ["advice"], True, workers=1, turn_seconds=0.5)
    assert 0 < card.failures < 12
    assert "of 8 seeds failed or were not played" in card.lines[0].why
    assert re.fullmatch(r".*0\.5.* \(faulty\.py, line \d+\)", card.error)


def test_nothing_is_begun_after_a_failure_that_matters(folder):
    many = study("faulty:Agent(fault='raises')", "random", seeds=50)
    with Store(folder / "s.db") as store:
        with pytest.raises(EpisodeError, match=r"^episode \{.* failed: KeyError"):
            play_missing(many, store, options=RunOptions("here", fail_fast=True))
        assert len(list(store.failures())) == 1
        assert store.count == 0


ODD = ["circle", "deep", "keys", "octets", "inside", "shown", "leaving", "ending"]


@pytest.mark.parametrize("id", ["llf-gridworld-v0", "llf-poem-Haiku-v0"])
@pytest.mark.parametrize("answer", ODD)
def test_an_answer_that_cannot_be_written_down_is_a_turn(folder, answer, id):
    (spec,) = study(f"faulty:Odd(answer='{answer}')", ids=[id]).episodes()
    result = run_episode(spec)
    assert isinstance(result, Packed), result
    assert result.episode.parse_failures == result.episode.turns == 3
    assert "that is no JSON" in unpack_turns(result.turns)[1]["parse_failure"]


@pytest.mark.parametrize("id", ["llf-gridworld-v0", "llf-poem-Haiku-v0", "llf-optimization-Booth-v0"])
@pytest.mark.parametrize("answer", [*ODD, "nine", "nan", "unspeakable"])
def test_a_native_action_that_there_is_not_is_a_turn_too(folder, answer, id):
    (spec,) = study(f"faulty:Native(answer='{answer}')", ids=[id]).episodes()
    result = run_episode(spec)
    assert isinstance(result, Packed), result
    assert result.episode.parse_failures == result.episode.turns == 3
    told = unpack_turns(result.turns)[1]
    assert told["parse_failure"]
    assert told["feedback"], "the teacher says what an action is"


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"limits": Limits(turn_seconds=0)}, "turn_seconds must be above 0, got 0"),
        ({"limits": Limits(memory=-1)}, "memory must be above 0, got -1"),
        ({"executor": "prosesses"}, "unknown executor 'prosesses'; did you mean processes"),
        ({"address": "auto"}, "the executor 'processes' has no address, got address='auto'"),
        ({"executor": "here", "address": "auto"}, "the executor 'here' has one worker and no address"),
    ],
)
def test_a_way_that_cannot_be_is_refused(tmp_path, changes, match):
    with Store(tmp_path / "s.db") as store, pytest.raises(ValueError, match=match):
        play_missing(study("random"), store, options=RunOptions(**changes))


def test_time_limits_are_for_the_main_thread(tmp_path):
    import threading

    errors = []

    def play_there():
        with Store(tmp_path / "s.db") as store:
            try:
                play_missing(study("random"), store, options=RunOptions("here", limits=Limits(turn_seconds=1)))
            except ValueError as error:
                errors.append(f"{error}")

    thread = threading.Thread(target=play_there)
    thread.start()
    thread.join()
    assert errors == ["limits of time can be enforced in the main thread only; play in processes, or leave them out"]


def test_a_limit_leaves_no_trace_here(folder):
    import resource

    before = resource.getrlimit(resource.RLIMIT_DATA), signal.getsignal(signal.SIGALRM), dict(os.environ)
    with Store(folder / "s.db") as store:
        students = "faulty:Agent(fault='sleeps')", "faulty:Agent(fault='eats')", "random"
        with pytest.raises(EpisodeError, match="2 of 3"):
            play_missing(
                study(*students),
                store,
                options=RunOptions("here", limits=Limits(turn_seconds=2, memory=data_of_this_process() + 200)),
            )
        told = {row["reason"]: row["error"] for row in store.failures()}
        assert set(told) == {"time", "memory"}
        assert re.search("^turn 1 was not over after 2 seconds" + PLACE, told["time"])
        assert store.count == 1
    after = resource.getrlimit(resource.RLIMIT_DATA), signal.getsignal(signal.SIGALRM), dict(os.environ)
    assert after == before
    assert signal.getitimer(signal.ITIMER_REAL) == (0, 0)
    sys.modules["faulty"].KEPT.clear()


def signals(first):
    """Two signals that end a study, each with the status that it gives; one of them by default."""
    statuses = {signal.SIGINT: 130, signal.SIGTERM: 143}
    return [
        pytest.param(number, status, id=number.name, marks=() if number is first else pytest.mark.full)
        for number, status in statuses.items()
    ]


@pytest.mark.parametrize(("number", "status"), signals(signal.SIGINT))
def test_a_signal_ends_a_study_within_seconds(folder, number, status):
    """Of agents that do not let themselves be disturbed, too."""
    (folder / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nseeds = 1\nmax_turns = 3\n'
        'students = ["random", "faulty:Agent(fault=\'deaf\')"]\n'
    )
    command = [sys.executable, "-m", "llf_teacher", "study", "run", "study.toml", "--workers", "2"]
    process = subprocess.Popen(
        command,
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # jobs in the background ignore it
    )
    path = folder / "study.db"
    while process.poll() is None and not played(path):
        time.sleep(0.05)
    sent = time.monotonic()
    os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    told = process.communicate(timeout=60)[1]
    assert process.returncode == status, told
    assert time.monotonic() - sent < 15
    assert "The episodes so far are in study.db; the same command resumes the study." in told
    assert "Traceback" not in told
    with Store(path) as store:
        assert [row["student"] for row in store.episodes()] == ["random"]
        assert not list(store.failures())
    assert not (folder / "study.db-lock").exists()


@pytest.mark.parametrize(("number", "status"), signals(signal.SIGTERM))
def test_a_signal_while_the_report_is_written_has_its_status(tmp_path, number, status):
    (tmp_path / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nstudents = ["random"]\nseeds = 1\nmax_turns = 3\n'
    )
    process = subprocess.Popen(
        [sys.executable, "-m", "llf_teacher", "study", "run", "study.toml", "--executor", "here"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    told = ""
    while "Writing the report" not in told:  # which takes as long as Matplotlib's import
        told += (line := process.stderr.readline())
        assert line, told
    process.send_signal(number)
    told += process.communicate(timeout=60)[1]
    assert process.returncode == status, told
    assert "The episodes so far are in study.db; the same command resumes the study." in told
    assert "Traceback" not in told
    assert not list(tmp_path.glob("*.html*")) + list(tmp_path.glob(".*"))
    with Store(tmp_path / "study.db") as store:
        assert store.count == 1


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux ends a process with its parent")
def test_a_worker_in_a_loop_of_c_ends_with_its_killed_driver(folder):
    (folder / "study.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nseeds = 1\nmax_turns = 3\n'
        "students = [\"faulty:Agent(fault='loops')\"]\n"
    )
    command = [sys.executable, "-m", "llf_teacher", "study", "run", "study.toml", "--workers", "2"]
    driver = subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
    try:
        while not (worker := read_number(folder / "looping.pid")):
            assert driver.poll() is None
            time.sleep(0.05)
    finally:
        driver.kill()
        driver.wait()
    end = time.monotonic() + 10
    while runs(worker) and time.monotonic() < end:
        time.sleep(0.05)
    assert not runs(worker), os.kill(worker, signal.SIGKILL)


def read_number(path):
    return int(path.read_text() or 0) if path.exists() else 0


def runs(process):
    """Whether a process runs; one that has ended may wait for its new parent to take its status."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_clock_that_jumps_fails_no_episode(folder, monkeypatch):
    began, now = time.time(), time.time
    jumps = iter(range(1, 1_000_000))
    monkeypatch.setattr(time, "time", lambda: now() + 86_400 * next(jumps) * (-1) ** int(now() - began))
    with Store(folder / "s.db") as store:
        limits = Limits(episode_seconds=60, turn_seconds=60)
        assert (
            play_missing(study("faulty:Agent(seconds=0.3)", seeds=2), store, 2, options=RunOptions(limits=limits)) == 2
        )


SCRIPT = """
{before}
from llf_teacher.studies import Study, run

study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=["random"], seeds=2, max_turns=3)
{guard}print(run(study, "s.db", workers=2))
"""


def script(folder, before="", guard=""):
    """What a script prints, and its exit status."""
    (folder / "script.py").write_text(SCRIPT.format(before=before, guard=guard))
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=folder, capture_output=True, text=True, timeout=120, check=False
    )
    return done.stdout + done.stderr, done.returncode


@pytest.mark.parametrize(
    "method", ["", *(pytest.param(each, marks=pytest.mark.full) for each in ("spawn", "forkserver"))]
)
def test_a_script_without_a_guard_is_told_so(tmp_path, method):
    before = f"import multiprocessing; multiprocessing.set_start_method({method!r})" if method else ""
    told, status = script(tmp_path, before)
    assert status == 1
    assert len(told.splitlines()) < 12, told
    assert f"{tmp_path / 'script.py'}, line 6, plays in other processes" in told.splitlines()[-1]
    assert 'put what a script does under `if __name__ == "__main__":`, or play in this process' in told.splitlines()[-1]
    assert not (tmp_path / "s.db").exists()
    guard = f'if __name__ == "__main__":\n    {before or "pass"}\n    '
    assert script(tmp_path, guard=guard) == ("Results('s.db', 2 episodes)\n", 0)


def test_a_script_with_another_condition_is_told_so_by_its_processes(tmp_path):
    told, status = script(tmp_path, guard="if study:\n    ")
    assert status == 1
    assert "worker processes end as soon as they start" in told.splitlines()[-1]
    assert 'under `if __name__ == "__main__":`' in told.splitlines()[-1]


@pytest.mark.parametrize("arguments", [["-"], [], ["/dev/stdin"]])
def test_a_script_from_standard_input_is_told_what_to_do(tmp_path, arguments):
    text = SCRIPT.format(before="", guard='if __name__ == "__main__":\n    ')
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, input=text, text=True, timeout=120, check=False)
    assert done.returncode == 1
    assert re.search(
        r"StudyError: the script (<stdin>|/dev/stdin) is no file.*; write it to a file, or play in this process by "
        "workers=1$",
        done.stderr.splitlines()[-1],
    )


def data_of_this_process():
    """In megabytes, as Linux counts it."""
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmData:\s+(\d+) kB", status)[1]) // 1024


def played(path):
    """Whether a store has an episode."""
    if not path.exists():
        return False
    with contextlib.closing(sqlite3.connect(path)) as db:
        try:
            return db.execute("SELECT count(*) FROM episode").fetchone()[0] > 0
        except sqlite3.OperationalError:  # not written yet
            return False


def test_outside_of_a_terminal_progress_is_a_line_now_and_then(monkeypatch):
    seconds = iter([100.0, 101.0, 160.0, 219.0, 220.0])
    monkeypatch.setattr(progress_module, "time", SimpleNamespace(monotonic=lambda: next(seconds)))
    file = io.StringIO()
    with StudyProgress(Console(file=file, force_terminal=False)) as progress:
        progress(0, 2000)
        progress(3, 2000)
        assert file.getvalue() == ""
        progress(1500, 2000)
        progress(1500, 2000)
        progress(1500, 2000)
    lines = (
        "1,500 of 2,000 episodes after 60 s, 25 a second\n1,500 of 2,000 episodes after 120 s, none in the last 60 s\n"
    )
    assert file.getvalue() == lines


def test_on_a_terminal_progress_is_a_bar():
    file = io.StringIO()
    with StudyProgress(Console(file=file, force_terminal=True)) as progress:
        progress(0, 20)
        progress(20, 20)
    assert "20/20" in file.getvalue()


def test_the_memory_of_a_run_does_not_grow_with_the_study(tmp_path, monkeypatch):
    """Of a first run and of one that goes on; playing is left out."""
    record = play(next(study("random").episodes()))
    packed = Packed(record.episode, pack_turns(record.turns))
    monkeypatch.setattr(runner, "run_episode", lambda spec, limits: packed)

    def most(seeds):
        whole = study("random", seeds=seeds)
        peaks = []
        with Store(tmp_path / f"{seeds}.db") as store:
            for _ in range(2):
                tracemalloc.start()
                play_missing(whole, store, options=RunOptions("here"))
                peaks.append(tracemalloc.get_traced_memory()[1])
                tracemalloc.stop()
            assert store.count == seeds
        return max(peaks)

    most(10)  # what is loaded once
    assert most(2000) < most(100) + 500_000  # the specs of all episodes are some 1.5 MB
