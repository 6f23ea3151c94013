"""Studies on a Ray cluster of two nodes, on this machine: whoever dies, the rows are those of an undisturbed run."""

import contextlib
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time

import faulty
import pytest
import ray
from ray.cluster_utils import Cluster

from llf_teacher.studies.definition.study import Study, load_study
from llf_teacher.studies.execution import limits as limits_module
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, play_missing
from llf_teacher.studies.store import Store

pytestmark = pytest.mark.filterwarnings("default")
NODE = {"num_cpus": 1, "object_store_memory": 80_000_000}
STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle", "silent"]
students = ["random", "faulty:Agent(seconds=0.02)"]
seeds = 20
max_turns = 5
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the agents are, for the nodes too."""
    folder = tmp_path_factory.mktemp("agents")
    shutil.copy(faulty.__file__, folder)
    (folder / "study.toml").write_text(STUDY)
    before = dict(os.environ)
    os.environ["PYTHONPATH"] = f"{folder}{os.pathsep}{before.get('PYTHONPATH', '')}"
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture(scope="module")
def cluster(folder):
    cluster = Cluster(initialize_head=True, head_node_args=NODE | {"include_dashboard": False})
    cluster.add_node(**NODE)
    cluster.wait_for_nodes()
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture(scope="module")
def undisturbed(folder):
    with Store(folder / "whole.db") as store:
        assert play_missing(load_study(folder / "study.toml"), store, options=RunOptions("here")) == 80
    return content(folder / "whole.db")


def content(path):
    """Episodes and turns, whatever the order in which they were written."""
    with contextlib.closing(sqlite3.connect(path)) as db:
        packed = "SELECT key, packed FROM result JOIN story USING (number) ORDER BY key"
        return [db.execute(query).fetchall() for query in ("SELECT * FROM episode ORDER BY key", packed)]


def count(path):
    try:
        with contextlib.closing(sqlite3.connect(path)) as db:
            return db.execute("SELECT count(*) FROM result").fetchone()[0]
    except sqlite3.OperationalError:  # not written yet
        return 0


def test_a_killed_driver_goes_on(cluster, folder, undisturbed):
    command = [sys.executable, "-m", "llf_teacher", "study", "run", "study.toml", "--store", "killed.db"]
    command += ["--executor", "ray", "--address", cluster.address]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and count(folder / "killed.db") < 10:
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert 10 <= count(folder / "killed.db") < 80
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert content(folder / "killed.db") == undisturbed


def test_faults_fail_their_episodes(cluster, folder, monkeypatch):
    monkeypatch.setattr(limits_module, "_GRACE", 0.5)
    students = [f"faulty:Agent(seconds=0.02, fault='{fault}')" for fault in ("raises", "sleeps", "deaf", "exits")]
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=[*students, "random"], seeds=1)
    options = RunOptions("ray", address=cluster.address, limits=Limits(episode_seconds=4))
    with Store(folder / "faults.db") as store:
        with pytest.raises(EpisodeError, match=r"^4 of 5 episodes failed"):
            play_missing(study, store, options=options)
        assert [row["student"] for row in store.episodes()] == ["random"]
        failed = {row["student"]: (row["reason"], row["error"]) for row in store.failures()}
    lost = "its process or node was lost 4 times: "
    reasons = [failed[student][0] for student in students]
    assert reasons == ["raised", "time", "died", "died"]
    assert failed[students[0]][1].startswith("KeyError('no idea') (faulty.py, line ")
    assert all(failed[student][1].startswith(lost) for student in students[2:])


def test_a_lost_node_loses_no_episode(cluster, folder, undisturbed):
    more = cluster.add_node(**NODE)
    cluster.wait_for_nodes()
    removed = []

    def progress(done, total):
        if done >= 20 and not removed:
            removed.append(done)
            cluster.remove_node(more, allow_graceful=False)

    path = folder / "node.db"
    with Store(path) as store:
        assert (
            play_missing(
                load_study(folder / "study.toml"),
                store,
                options=RunOptions("ray", address=cluster.address),
                progress=progress,
            )
            == 80
        )
        assert not list(store.failures())
    assert removed[0] < 80
    assert content(path) == undisturbed


@pytest.mark.parametrize("address", ["127.0.0.1:1", "ray://localhost:1", "[::1]:1"])
def test_a_cluster_that_is_not_there_is_told_of_soon(folder, address):
    study = Study(ids=["llf-gridworld-v0"], teachers=["oracle"], students=["random"], seeds=1)
    began = time.monotonic()
    with Store(folder / "nowhere.db") as store:
        with pytest.raises(ConnectionError, match=re.escape(f"no Ray cluster can be reached at {address}: ")):
            play_missing(study, store, options=RunOptions("ray", address=address))
        assert store.empty
    assert time.monotonic() - began < 30
