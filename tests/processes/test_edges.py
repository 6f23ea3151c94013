"""At the edges: other people's files and names, text that steers terminals, extras that are not there."""

import os
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import llf
from design import amount

import llf_teacher
from llf_teacher.episodes.record import TurnRow, summary
from llf_teacher.escaping import escape_control_chars
from llf_teacher.models.client import Endpoint
from llf_teacher.models.settings import ClientSettings
from llf_teacher.registry import entry
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.runner import EpisodeError, play_missing
from llf_teacher.studies.store import Store

STUDY = """
ids = ["llf-gridworld-v0"]
teachers = ["oracle"]
students = ["_mine:Agent"]
seeds = 1
"""
AGENT = """
import random

import numpy as np


class Agent:
    def __init__(self, answer="north"):
        self.answer = answer

    def act(self, observation):
        return self.answer


class Gambler:
    def act(self, observation):
        return random.choice(["north", "east"]) if np.random.random() < 0.5 else random.choice(["west", "south"])


class Broken:
    def act(self, observation):
        raise KeyError("\\x1b[31mred\\x1b]0;title\\x07 \\u202e [/b]")
"""
EXTRA = """
import sys
from dataclasses import replace

from pz_envs import family
from pz_envs.families import gridworld, poem

family.own_families = lambda: (gridworld.FAMILY, replace(poem.FAMILY, extra="verse"))
family.all_families.cache_clear()
sys.modules["syllables"] = None
"""
ESCAPE, OVERRIDE = "\x1b", "\u202e"


def python(*arguments, cwd, **environment):
    command = [sys.executable, *arguments]
    return subprocess.run(
        command, cwd=cwd, capture_output=True, text=True, check=False, env={**os.environ, **environment}
    )


@pytest.mark.parametrize("file", ["worlds/__init__.py", "worlds.py", "teachers/__init__.py", "pz_envs.py"])
@pytest.mark.parametrize(
    "arguments",
    [("script.py",), ("-m", "llf_teacher", "list"), ("-c", "import llf_teacher")],
    ids=["script", "-m", "-c"],
)
def test_a_file_that_hides_a_package_is_named(tmp_path, file, arguments):
    path = tmp_path / file
    path.parent.mkdir(exist_ok=True)
    path.touch()
    (tmp_path / "script.py").write_text("import llf_teacher\n")
    result = python(*arguments, cwd=tmp_path)
    last = result.stderr.splitlines()[-1]
    assert last.startswith("ImportError: llf_teacher needs its own package ")
    assert f"Python finds {path} first; rename it" in last


def test_a_package_that_was_imported_before_is_named(tmp_path):
    (tmp_path / "teachers.py").touch()
    result = python("-c", "import teachers, llf_teacher", cwd=tmp_path)
    assert f"Python finds {tmp_path / 'teachers.py'} first" in result.stderr


def test_a_folder_that_is_no_package_hides_nothing(tmp_path):
    """If ours are on the path, as a wheel is; an editable installation comes last, and says what is in its way."""
    (tmp_path / "teachers").mkdir()
    code = "import llf_teacher; print(len(llf_teacher.ids()) > 8)"
    home = str(Path(llf_teacher.__file__).parents[1])
    result = python("-c", code, cwd=tmp_path, PYTHONPATH=home)
    assert result.stdout == "True\n", result.stderr
    if (Path(home) / "pyproject.toml").exists():
        last = python("-c", code, cwd=tmp_path, PYTHONPATH="").stderr.splitlines()[-1]
        assert "needs its own package 'teachers'" in last
        assert "finds a folder 'teachers' first" in last


def test_names_that_look_like_markup(tmp_path):
    (tmp_path / "_mine.py").write_text(AGENT)
    (tmp_path / "study.toml").write_text(STUDY.replace("_mine:Agent", "_mine:Agent(answer='[/b] \\u202e')"))
    command = ("study", "run", "study.toml", "--store", "x[.]y[b].db", "--report", "r[i].html", "--workers", "1")
    result = llf(*command, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "Played 1 episodes; x[.]y[b].db now has 1." in result.stderr
    assert "r[i].html" in "".join(result.stderr.split())
    page = (tmp_path / "r[i].html").read_text(encoding="utf-8")
    assert OVERRIDE not in page
    assert r"[/b] \u202e" in page
    assert page.count("_mine:Agent") > 2


def test_a_student_whose_module_begins_with_an_underscore_is_in_the_plots(tmp_path):
    (tmp_path / "_other.py").write_text(AGENT)
    (tmp_path / "study.toml").write_text(STUDY.replace("_mine", "_other"))
    result = llf("study", "run", "study.toml", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    page = (tmp_path / "study.html").read_text(encoding="utf-8")
    assert any("_other:Agent" in plot.partition("</svg>")[0] for plot in page.split("<svg")[1:])


def test_what_an_agent_says_does_not_steer_the_terminal(tmp_path):
    (tmp_path / "_mine.py").write_text(AGENT)
    (tmp_path / "study.toml").write_text(STUDY.replace("Agent", "Broken"))
    result = llf("study", "run", "study.toml", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 3
    assert ESCAPE not in result.stderr
    assert OVERRIDE not in result.stderr
    assert "[/b]" in result.stderr


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\tb\nç — 東京 🎬", "a\tb\nç — 東京 🎬"),
        ("\x1b[31m\x07\x9b", r"\x1b[31m\x07\x9b"),
        ("\u202egnp\u2066\u200b\ufeff", r"\u202egnp\u2066\u200b\ufeff"),
        ("\ud800", r"\ud800"),
    ],
)
def test_visible(text, shown):
    assert escape_control_chars(text) == shown


def test_global_generators_are_seeded_per_episode_in_workers_only(tmp_path, monkeypatch):
    (tmp_path / "gamblers_of_mine.py").write_text(AGENT)
    monkeypatch.syspath_prepend(tmp_path)
    study = Study(
        ids=("llf-gridworld-v0",),
        teachers=("silent",),
        students=("gamblers_of_mine:Gambler",),
        seeds=(0, 1, 2, 3),
        max_turns=8,
    )
    before = random.getstate(), np.random.get_state()[1].tolist()  # noqa: NPY002
    played = []
    for name, workers in (("one", 1), ("two", 2)):
        with Store(tmp_path / f"{name}.db") as store:
            play_missing(study, store, workers=workers)
            played.append([[turn["action"] for turn in store.turns(spec.key)] for spec in study.episodes()])
    assert played[0] == played[1]
    assert len({tuple(map(str, actions)) for actions in played[0]}) == 4
    assert (random.getstate(), np.random.get_state()[1].tolist()) == before  # noqa: NPY002


REPLACES = """
import json
import math
import random
import time

import numpy as np


class Always(np.random.Generator):
    def __eq__(self, other):
        return True


class Agent:
    what = "default_rng"

    def act(self, observation):
        if self.what == "default_rng":
            np.random.default_rng = lambda seed=None: Always(np.random.PCG64(7))
        elif self.what == "random":
            random.Random.choice, random.choice = random.Random.choice, lambda values: values[0]
        elif self.what == "gone":
            del math.fsum
        elif self.what == "builtin":
            import builtins

            builtins.sorted = lambda *args, **kwargs: list(args[0])
        elif self.what == "json":
            json.loads = lambda text, **kwargs: {}
        elif self.what == "method":
            json.JSONEncoder.encode = lambda self, value: "{}"
        elif self.what == "clock":
            time.monotonic = lambda: 0.0
        elif self.what == "constant":
            np.pi = 3
        return "north"


class Random(Agent):
    what = "random"


class Gone(Agent):
    what = "gone"


class Builtin(Agent):
    what = "builtin"


class Json(Agent):
    what = "json"


class Method(Agent):
    what = "method"


class Timer(Agent):
    what = "clock"


class Constant(Agent):
    what = "constant"


def patched(seconds):
    pass  # what a library leaves in the place of `time.sleep`


class Patches(Agent):
    what = "nothing of the above"

    def act(self, observation):
        time.sleep = patched
        return 0
"""


@pytest.mark.parametrize("workers", [1, 2])
def test_an_agent_that_replaces_what_others_draw_by_fails_alone(tmp_path, monkeypatch, workers):
    name = f"replaces_{workers}"
    (tmp_path / f"{name}.py").write_text(REPLACES)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH")))))
    changing = {"Agent": "numpy.random.default_rng", "Random": "random.choice", "Gone": "math.fsum"}
    changing |= {"Builtin": "builtins.sorted", "Json": "json.loads", "Method": "json.encoder.JSONEncoder.encode"}
    changing |= {"Timer": "time.monotonic", "Constant": "numpy.pi", "Patches": "time.sleep"}
    common = {"ids": ("llf-gridworld-v0", "llf-optimization-Booth-v0"), "teachers": ("oracle",), "max_turns": 3}
    alone = Study(**common, students=("random",), seeds=3)
    study = Study(**common, students=(*(f"{name}:{each}" for each in changing), "random"), seeds=3)
    with Store(tmp_path / "alone.db") as store, Store(tmp_path / "both.db") as both:
        play_missing(alone, store, workers=1)
        with pytest.raises(EpisodeError, match="54 of 60 episodes failed"):
            play_missing(study, both, workers=workers)
        assert sorted(map(tuple, both.episodes())) == sorted(map(tuple, store.episodes()))
        for row in both.failures():
            what = changing[row["student"].partition(":")[2]]
            assert row["error"].startswith(f"{what} was replaced during the episode (by "), row["error"]
            if what == "time.sleep":
                assert f"(by {name}.patched)" in row["error"]
                assert "A library that replaces such functions for good" in row["error"]


def test_sums_do_not_depend_on_the_order_or_the_python():
    rows = [TurnRow(n, "", None, None, 0.1, 0.1, False, None, None, "", []) for n in range(10)]
    found = summary("family", "words", rows)
    assert (found.total_reward, found.regret) == (1.0, 1.0)


@pytest.mark.parametrize(
    ("url", "warned"),
    [
        ("http://models.example/v1", True),
        ("http://10.0.0.7:8000/v1", True),
        ("http://localhost:8000/v1", False),
        ("http://127.0.0.1:8000/v1", False),
        ("http://[::1]:8000/v1", False),
        ("https://models.example/v1", False),
    ],
)
def test_a_key_that_goes_unencrypted_to_another_machine_is_warned_of(url, warned, recwarn):
    for key in ("sk-secret-0123456789", ""):
        recwarn.clear()
        Endpoint(url, ClientSettings(key=key, cache=":memory:", budget=None, timeout=1.0, retries=0))
        said = [str(each.message) for each in recwarn if "for everyone to read; use https" in str(each.message)]
        assert len(said) == (warned and key != "")


def test_a_family_without_a_wheel_for_this_python_says_why():
    family = replace(entry("llf-metaworld-reach-v3").family, world="elsewhere_metaworld:World")
    family = replace(family, oracle="elsewhere_metaworld:Oracle", python_below=sys.version_info[:2])
    version = ".".join(map(str, sys.version_info[:2]))
    why = f"needs 'elsewhere_metaworld', which is not installed; it has no wheel for Python {version} and later: use an"
    with pytest.raises(ModuleNotFoundError, match=why):
        family.make_world()
    assert why in family.missing()
    later = replace(family, python_below=(sys.version_info[0] + 1, 0))
    assert later.missing() == ""
    with pytest.raises(ModuleNotFoundError, match="not installed; run: pip install"):
        later.make_world()


def test_metaworld_is_missed_before_a_world_is_made(monkeypatch):
    """The world imports it late, since that takes seconds."""
    for name in [each for each in sys.modules if each.startswith(("worlds.metaworld", "teachers.oracles.metaworld"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "metaworld", None)
    family = replace(entry("llf-metaworld-reach-v3").family, python_below=sys.version_info[:2])
    why = "the family 'metaworld' needs 'metaworld', which is not installed; it has no wheel for Python"
    assert family.missing().startswith(why)
    with pytest.raises(ModuleNotFoundError, match=why):
        family.make_world(task="reach-v3")


def test_the_marker_and_the_family_name_the_same_python():
    pyproject = Path(__file__).parents[2] / "pyproject.toml"
    below = entry("llf-metaworld-reach-v3").family.python_below
    assert f"metaworld>=3.1; python_version < '{below[0]}.{below[1]}'" in pyproject.read_text(encoding="utf-8")


def test_what_needs_an_extra_that_is_missing_is_left_out_and_said_so(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(EXTRA)
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    for command in (("list",), ("dev", "tables"), *amount((), full=[("dev", "golden", "out")])):
        result = python("-m", "llf_teacher", *command, cwd=tmp_path, PYTHONPATH=path)
        assert result.returncode == 0, result.stderr
        assert result.stderr.count("pip install 'llf-teacher[verse]'") == 1
        assert len(result.stderr.strip().splitlines()) == 1
        assert "llf-poem" not in result.stdout
        assert "gridworld" in result.stdout
    code = (
        "from llf_teacher.studies.definition.study import quickstart\n"
        "from llf_teacher.cli import audit\n"
        "audit._audits = lambda jobs, workers: print(sorted({job[0] for job in jobs})) or iter(())\n"
        "print(quickstart().ids)\n"
        "audit.audit(None, ['silent'], 10, 'a', 'plain', 1, True)\n"
    )
    result = python("-c", code, cwd=tmp_path, PYTHONPATH=path)
    assert result.returncode == 0, result.stderr
    assert "llf-poem" not in result.stdout
    assert result.stdout.count("llf-gridworld-v0") == 2
    assert result.stderr.count("left out: ") == 1
