"""A tiny model of random weights is taught with a budget of words, is killed in an update, and goes on as before."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
sys.path.insert(0, f"{ROOT / 'examples'}")
import teachers_for_a_model as program  # noqa: E402
from word_training import RATES, Learner  # noqa: E402

SMALL = {"updates": 3, "format": 1, "steps": 8, "worlds": 4, "words": 30}


@pytest.fixture(scope="module")
def learner(folder):
    return Learner(f"{folder}")


@pytest.fixture
def settings(folder):
    return {**SMALL, "model": f"{folder}", "dtype": "float32", "family": "gridworld", "rates": {"f": RATES["sft"]}}


def rows_of(run, learner):
    """The rows of a run to its end, without what depends on the machine's speed."""
    run.go(learner)
    return [{key: value for key, value in row.items() if key not in ("seconds", "cpu")} for row in run.rows.read()]


def test_it_is_taught_within_the_budget_and_killed_it_goes_on_with_the_same_result(tmp_path, settings, learner):
    name, whole, cut = "mistake_correcting", tmp_path / "whole", tmp_path / "cut"
    rows = rows_of(program.Taught(whole, name, 0, settings), learner)
    houses = [row for row in rows if row["kind"] == "house"]
    assert len(houses) == 16
    assert 0 < sum(row["words"] for row in houses) <= 30
    assert all(row["target"] == bool(row["said"]) for row in houses)
    updates = [row for row in rows if row["kind"] == "update"]
    assert [row["steps"] for row in updates] == [8, 8, 8], "equal environment steps"
    assert all(row["loss"] > 0 and row["examples"] == 8 for row in updates)

    given = [word for key, value in SMALL.items() for word in (f"--{key}", f"{value}")]
    command = [sys.executable, f"{ROOT / 'examples/teachers_for_a_model.py'}", "--out", f"{cut}", *given]
    command += ["--model", settings["model"], "--teachers", name]
    one_thread = {**os.environ, "OMP_NUM_THREADS": "1"}  # as `folder` has set it here: another number sums otherwise
    begun = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, env=one_thread)
    while not [*cut.glob(f"{name}-0/checkpoint-00002")]:
        assert begun.poll() is None, "it ended before it could be killed"
        time.sleep(0.01)
    os.kill(begun.pid, signal.SIGKILL)
    begun.wait()
    again = program.Taught(cut, name, 0, settings)
    assert not again.done
    assert rows_of(again, learner) == rows


def test_the_pilot_measures_a_stage(tmp_path, settings, learner):
    lines = program.pilot(learner, tmp_path, ["early"], 2, settings, program.Taught)
    assert lines[0].startswith("(early) ")
    assert lines[1].startswith("2 runs: about ")
    assert not [*tmp_path.iterdir()]
