"""What was explored is stored on disk, and nothing that is damaged or out of date is believed."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from minigrid.minigrid_env import MiniGridEnv

from teachers.planning import Exact, PlanningError, cache
from teachers.planning.exact import exploring
from teachers.planning.transitions import Transition

pytestmark = pytest.mark.usefixtures("short_trials")

ID = "MiniGrid-Empty-5x5-v0"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def explorations(monkeypatch):
    """The explorations that were made."""
    made = []
    explore = exploring.explore
    monkeypatch.setattr(exploring, "explore", lambda *args, **bounds: made.append(explore(*args, **bounds)) or made[-1])
    return made


def plan(**options):
    return Exact(**options).plan(gymnasium.make(ID), 100)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A file of what was explored, and its transitions."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        monkeypatch.setenv(cache.FOLDER, str(tmp_path_factory.mktemp("cache")))
        found = transitions(plan())
        (file,) = cache.folder().iterdir()
    return file, found


def transitions(planned):
    return planned.model._known[0].values.transitions


def test_an_environment_is_explored_once(folder, explorations):
    first = transitions(plan())
    assert transitions(plan()) == first
    assert len(explorations) == 1
    assert len(list(folder.iterdir())) == 1
    transitions(Exact().plan(gymnasium.make(ID, agent_start_pos=(2, 2)), 100))
    assert len(explorations) == 2


@pytest.mark.parametrize(
    "damage",
    [
        "cut",
        *(pytest.param(each, marks=pytest.mark.full) for each in ("empty", "text")),
        "other",
        "changed",
        "unpaid",
        "late",
    ],
)
def test_a_damaged_file_is_explored_anew_and_mended(folder, explorations, damage, whole):
    stored, first = whole
    folder.mkdir()
    file = Path(shutil.copy(stored, folder))
    if damage == "other":
        np.savez(file, states=np.zeros(3, np.uint8))
    elif damage == "changed":  # as of an environment that does something else
        cache.save(file.stem.removeprefix("plan-"), {state: rows[::-1] for state, rows in first.items()})
    elif damage in ("unpaid", "late"):  # of what a walk at random hardly meets
        other = {"reward": 0.0} if damage == "unpaid" else {"state": next(iter(first))}
        paid = {s: [[t._replace(**other) if t.reward else t for t in ts] for ts in rows] for s, rows in first.items()}
        cache.save(file.stem.removeprefix("plan-"), paid)
    else:
        file.write_bytes(
            {"cut": stored.read_bytes()[: stored.stat().st_size // 2], "empty": b"", "text": b"hello" * 100}[damage]
        )
    assert transitions(plan()) == first
    assert len(explorations) == 1
    assert transitions(plan()) == first
    assert len(explorations) == 1


def test_objects_are_not_loaded(folder):
    """A file with a pickle in it is none of ours."""
    folder.mkdir()
    np.savez(folder / "plan-x.npz", states=np.array([{"a": 1}], dtype=object), counts=np.zeros((1, 1)))
    assert cache.load("x") is None


def test_states_come_back_as_they_were(folder):
    states = [(1, ("a", None), b"\x00\xff", True, 1.5), ("é", -3), 7, None]
    table = {state: [[Transition(0.25, states[1], -1.0), Transition(0.75, None, 2.0)], []] for state in states}
    cache.save("key", table)
    assert cache.load("key") == table
    cache.save("strange", {frozenset({1}): [[]]})
    assert cache.load("strange") is None


def test_it_can_be_switched_off(monkeypatch, tmp_path, explorations):
    monkeypatch.setenv(cache.FOLDER, "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    plan()
    plan()
    assert len(explorations) == 2
    assert not list(tmp_path.iterdir())
    monkeypatch.delenv(cache.FOLDER)
    assert cache.folder() == tmp_path / "llf-teacher"


def test_a_folder_that_cannot_be_written_is_no_error(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(cache.FOLDER, str(tmp_path / "file" / "below"))
    assert plan().tier == "exact"


def test_files_are_bounded_and_half_files_go(folder, monkeypatch):
    table = {0: [[Transition(1.0, None, 0.0)]]}
    cache.save("a", table)
    size = (folder / "plan-a.npz").stat().st_size
    monkeypatch.setattr(cache, "MOST", 2 * size)
    for place, name in enumerate("ab"):
        cache.save(name, table)
        os.utime(folder / f"plan-{name}.npz", (time.time() + place - 100,) * 2)
    (folder / "old.half").write_text("")
    os.utime(folder / "old.half", (0, 0))
    (folder / "new.half").write_text("")
    assert cache.load("a") == table  # is now the one that was used last
    cache.save("c", table)
    assert {path.name for path in folder.iterdir()} == {"plan-a.npz", "plan-c.npz", "new.half"}


def test_writers_do_not_disturb_each_other(folder):
    writers = [subprocess.Popen([sys.executable, "-c", _WRITER]) for _ in range(2)]
    assert [writer.wait(timeout=120) for writer in writers] == [0, 0]
    assert cache.load("same") == {state: [[Transition(1.0, (state + 1) % 500, 0.0)]] for state in range(500)}
    assert [path.name for path in folder.iterdir()] == ["plan-same.npz"]


_WRITER = """
from teachers.planning import cache
from teachers.planning.transitions import Transition

for _ in range(10):
    cache.save("same", {state: [[Transition(1.0, (state + 1) % 500, 0.0)]] for state in range(500)})
"""


class Doubled(gymnasium.RewardWrapper):
    """A wrapper that is not installed."""

    def reward(self, reward):
        return 2 * reward


class Mine(gymnasium.Env):
    """Is not installed either, so that its code may change from one run to the next."""


def test_what_may_change_has_no_key():
    env = gymnasium.make(ID)
    assert cache.key_of(env, 1) == cache.key_of(gymnasium.make(ID), 1) != cache.key_of(env, 2)
    assert cache.key_of(env, object()) == ""
    assert cache.key_of(Doubled(env)) == ""
    assert cache.key_of(gymnasium.wrappers.TransformReward(env, lambda reward: 2 * reward)) == ""
    assert cache.key_of(Mine()) == ""


def test_an_environment_with_a_method_of_its_own_has_no_key(folder):
    changed = gymnasium.make(ID)
    changed.unwrapped._reward = lambda: 0.0
    assert cache.key_of(changed, 1) == ""
    with pytest.raises(PlanningError):  # the rules that are known of MiniGrid are not its own
        Exact().plan(changed, 100)
    assert not folder.exists()
    assert max(one.reward for row in transitions(plan()).values() for each in row for one in each) == 1


def test_a_method_that_is_patched_into_a_class_is_noticed(monkeypatch):
    assert cache.key_of(gymnasium.make(ID), 1)
    monkeypatch.setattr(MiniGridEnv, "_reward", lambda self: 0.0)
    assert cache.key_of(gymnasium.make(ID), 1) == ""


def test_the_attributes_of_an_environment_are_in_its_key(folder, explorations):
    plan()
    changed = gymnasium.make(ID)
    changed.unwrapped.hint = 1
    Exact().plan(changed, 100)
    assert len(explorations) == 2
