"""Studies whose own teachers, students and worlds change between runs."""

import re
import sys
import textwrap
import types
import zipfile

import gymnasium
import pytest
from commands import llf

from llf_teacher.studies import load, run
from llf_teacher.studies.definition.fingerprints import fingerprints
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.store import StoreError
from llf_teacher.studies.store.merging import merge
from llf_teacher.suite import take
from llf_teacher.suite.card import Card

MOODS = '''
"""Moods."""
from dataclasses import dataclass
from teachers.personality import Personality, Stage
from helper_moods import SULKS

class _Sulks(Stage):
    """Says nothing when it sulks."""

    def speak(self, claims, view):
        # every other turn
        return () if SULKS else claims

@dataclass(frozen=True)
class Grudge(Personality):
    stage = _Sulks

def player():
    class Player:
        def act(self, observation):
            return "0"
    return Player()
'''
COMMENTED = '''
# A new comment.
from dataclasses import dataclass
from teachers.personality import Personality, Stage

from helper_moods import SULKS



class _Sulks(Stage):
    """Keeps still when it sulks: another docstring."""

    def speak(self, claims, view):
        """A docstring where none was."""
        return (  # in lines
            ()
            if SULKS
            else claims
        )


@dataclass(frozen=True)
class Grudge(Personality):
    stage = _Sulks
    """A text."""
    pass


def player():
    class Player:
        def act(self, observation):
            return '0'

    return Player()
'''


@pytest.fixture
def moods(tmp_path, monkeypatch):
    """A function that writes modules, as a new process would import them."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(textwrap.dedent(text))
            sys.modules.pop(name, None)
        sys.modules.pop("moods", None)
        sys.path_importer_cache.clear()

    write(moods=MOODS, helper_moods="SULKS = True")
    yield write
    for name in ("moods", "helper_moods"):
        sys.modules.pop(name, None)


def study(**changes):
    settings = {
        "ids": ["llf-gridworld-v0"],
        "teachers": ["moods:Grudge", "silent"],
        "students": ["obedient"],
        "seeds": 2,
        "max_turns": 3,
    }
    return Study(**(settings | changes))


def play(path, changed="stop", **changes):
    return run(study(**changes), path, options=RunOptions("here", changed=changed))


def regrets(path, teacher):
    with load(path) as results:
        return {row["seed"]: row["regret"] for row in results.rows() if row["teacher"] == teacher}


def test_a_changed_teacher_stops_the_study_and_says_which(tmp_path, moods):
    path = tmp_path / "s.db"
    play(path).close()
    sulking = regrets(path, "moods:Grudge")
    moods(moods=MOODS.replace("if SULKS", "if not SULKS"))
    with pytest.raises(
        StoreError,
        match=r"s.db: moods:Grudge has changed since 2 episodes .* \(changed: moods\).*--replay-changed.*--keep-old",
    ):
        play(path, seeds=3)
    assert regrets(path, "moods:Grudge") == sulking  # nothing was played
    assert len(regrets(path, "silent")) == 2
    with play(path, "replay", seeds=3) as results:
        assert sum(row["revision"] == 2 for row in results.rows()) == 4  # and two of silence stay
    again = regrets(path, "moods:Grudge")
    assert len(again) == 3
    assert sum(again.values()) < sum(sulking.values())
    play(path, seeds=3).close()  # all are of one version now


def test_old_episodes_can_be_kept_knowingly(tmp_path, moods):
    path = tmp_path / "s.db"
    play(path).close()
    moods(helper_moods="SULKS = False")
    with pytest.raises(StoreError, match=r"moods:Grudge has changed .* \(changed: helper_moods\)"):
        play(path, seeds=3)
    with play(path, "keep", seeds=3) as results:
        assert [row["revision"] for row in results.rows() if row["teacher"] == "moods:Grudge"] == [1, 1, 2]
    with pytest.raises(StoreError, match="moods:Grudge has changed since 2 episodes"):
        play(path, seeds=3)


def test_comments_docstrings_and_layout_are_no_change(tmp_path, moods):
    path = tmp_path / "s.db"
    play(path, students=["obedient", "moods:player"]).close()
    moods(moods=COMMENTED, helper_moods="# why\nSULKS = True\n")
    with play(path, students=["obedient", "moods:player"], seeds=3) as results:
        assert len(list(results.rows())) == 12
    moods(helper_moods="SULKS = 1")
    with pytest.raises(StoreError, match=r"moods:Grudge has changed .* moods:player has changed"):
        play(path, students=["obedient", "moods:player"], seeds=3)


def test_a_module_that_reads_its_docstring_changes_with_it(moods):
    first, second = (
        "def f(prompt):\n    'Say 0.'\n    return f.__doc__",
        "def f(prompt):\n    'Say 1.'\n    return f.__doc__",
    )
    found = []
    for text in (first, second):
        moods(moods=text)
        found.append(fingerprints(["chat:moods:f"]))
    assert found[0] != found[1]


def test_prompts_beside_a_module_count_and_what_cannot_be_seen_is_said(tmp_path, moods):
    text = """
    from pathlib import Path
    import numpy
    def f(prompt):
        import importlib
        importlib.import_module(prompt)
        return Path(__file__).with_name("prompt.txt").read_text()
    """
    (tmp_path / "prompt.txt").write_text("Say 0.")
    moods(moods=text)
    first = fingerprints(["chat:moods:f", "oracle", "llf-gridworld-v0"])
    assert first.keys() == {"chat:moods:f"}
    mine = first["chat:moods:f"]
    assert mine.modules.keys() == {"moods", "moods: prompt.txt"}
    assert mine.unseen == (
        "what `import_module` in line 6 of moods reads or runs",
        "what `read_text` in line 7 of moods reads or runs",
        "the installed packages numpy",
    )
    (tmp_path / "prompt.txt").write_text("Say 1.")
    assert fingerprints(["chat:moods:f"]) != first
    moods(moods=text.replace("return", "Path('prompt.txt').write_text(prompt)\n        return"))
    assert fingerprints(["chat:moods:f"])["chat:moods:f"].modules.keys() == {"moods"}  # what it writes itself changes


def test_packages_and_relative_imports_are_followed(tmp_path, moods):
    for name, text in {
        "__init__": "",
        "agents": "from . import parts\nfrom .deep.more import X\ndef make():\n    from packed_moods.lazy import Y\n",
        "parts": "A = 1",
        "lazy": "Y = 1",
        "unused": "Z = 1",
        "deep/__init__": "import packed_moods.agents",
        "deep/more": "X = 1",
    }.items():
        file = tmp_path / "packed_moods" / f"{name}.py"
        file.parent.mkdir(exist_ok=True, parents=True)
        file.write_text(text)
    found = fingerprints(["packed_moods.agents:make(n=1) | mishears"])
    (mine,) = found.values()
    inner = {f"packed_moods.{name}" for name in ("agents", "parts", "lazy", "deep", "deep.more")}
    assert mine.modules.keys() == {"packed_moods", *inner}
    assert not any(name.startswith("packed_moods") for name in sys.modules)  # nothing was imported


def test_own_environments_count(tmp_path, moods):
    text = """
    import gymnasium
    class Coin(gymnasium.Env):
        observation_space = action_space = gymnasium.spaces.Discrete(2)
        def reset(self, *, seed=None, options=None):
            return 0, {}
        def step(self, action):
            return 0, 1.0, True, False, {}
    gymnasium.register("CoinOfMoods-v0", entry_point="moods:Coin", max_episode_steps=3)
    """
    moods(moods=text)
    id = "gym:moods:CoinOfMoods-v0"
    found = fingerprints([id, "gym:CartPole-v1"])
    gymnasium.registry.pop("CoinOfMoods-v0")
    assert found.keys() == {id}
    assert found[id].modules.keys() == {"moods"}


def test_other_rules_of_a_family_stop_the_study(tmp_path, monkeypatch):
    path = tmp_path / "s.db"
    mine = study(teachers=["oracle", "silent"])
    options = RunOptions("here")
    run(mine, path, options=options).close()
    later = study(teachers=["oracle", "silent"])
    version, rules = later.versions["gridworld"]
    vars(later)["versions"] = {"gridworld": (version, f"{rules}9")}
    with pytest.raises(
        StoreError, match=rf"The family gridworld plays otherwise than in 4 episodes .* \(rules {rules}, now {rules}9\)"
    ):
        run(later, path, options=options)
    with run(later, path, options=options._replace(changed="keep")) as results:
        assert len(list(results.rows())) == 8
    run(later, path, options=options).close()  # its own episodes are there, the others are not of this study
    vars(mine)["versions"] = {"gridworld": ("0.0.1", rules)}
    with pytest.raises(StoreError, match=r"The family gridworld .* \(version .*, now 0.0.1\)"):
        run(mine, tmp_path / "s.db", options=options)


NOTEBOOK = '''
from dataclasses import dataclass
from teachers.personality import Personality, Stage
SEEDS = {seeds}
QUIET = {quiet}
class _Sulks(Stage):
    made = 0
    def speak(self, claims, view):
        _Sulks.made += 1
        return () if QUIET else claims
@dataclass(frozen=True)
class Grudge(Personality):
    """{docs}"""
    stage = _Sulks
def study():
    return SEEDS
'''


def test_what_a_notebook_defines_counts_without_the_code_that_runs_the_study(monkeypatch):
    def made(**values):
        main = types.ModuleType("__main__")
        monkeypatch.setitem(sys.modules, "__main__", main)
        text = NOTEBOOK.format(**({"seeds": 20, "quiet": True, "docs": "It sulks."} | values))
        exec(compile(text, "a cell", "exec"), vars(main))
        main._Sulks.made = values.get("seeds", 0)
        return fingerprints(["__main__:Grudge"])

    assert made() == made(seeds=22) == made(docs="It never sulks.")
    assert made() != made(quiet=False)


def test_an_unknown_choice_is_refused(tmp_path):
    with pytest.raises(ValueError, match="changed must be one of stop, replay, keep, got 'all'"):
        play(tmp_path / "s.db", "all", teachers=["silent"])


FILE = """
ids = ["llf-gridworld-v0"]
teachers = ["moods:Grudge", "silent"]
students = ["obedient"]
max_turns = 3
seeds = {}
"""


def test_the_command_line_stops_replays_or_keeps_and_marks_the_report(tmp_path, moods):
    file, command = tmp_path / "mine.toml", ("study", "run", "mine.toml", "--executor", "here")
    file.write_text(FILE.format(2))
    assert llf(*command, cwd=tmp_path).returncode == 0
    moods(helper_moods="import numpy\nSULKS = False")
    file.write_text(FILE.format(3))
    stopped = llf(*command, cwd=tmp_path)
    assert stopped.returncode == 2
    assert "moods:Grudge has changed since 2 episodes of this study, which the store has" in stopped.stderr
    assert llf(*command, "--replay-changed", "--keep-old", cwd=tmp_path).returncode == 2
    kept = llf(*command, "--keep-old", cwd=tmp_path)
    assert kept.returncode == 0, kept.stderr
    mark = "Not one result: moods:Grudge has changed between episodes, 2 and 1 were played with different code"
    assert f"- {mark}." in " ".join(kept.stderr.split())
    unseen = "Of moods:Grudge, a run does not compare the installed packages numpy"
    assert unseen not in " ".join(kept.stderr.split()), "only a check and an archive say what nobody asked about"
    (store,), (page,) = tmp_path.glob("*.db"), tmp_path.glob("*.html")
    assert mark in page.read_text(encoding="utf-8")
    checked = llf("study", "check", store, cwd=tmp_path)
    assert (checked.returncode, mark in checked.stderr) == (0, True)
    assert unseen in checked.stderr
    moods(helper_moods="import numpy\nSULKS = None")
    file.write_text(FILE.format(2))
    assert llf(*command, "--keep-old", cwd=tmp_path).returncode == 0
    old = "Old code: moods:Grudge has changed since its 2 episodes were played"
    assert old in page.read_text(encoding="utf-8"), "nothing was played, and all is of older code"
    file.write_text(FILE.format(3))
    again = llf(*command, "--replay-changed", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert not re.search("Not one result|Old code", page.read_text(encoding="utf-8"))
    assert "Played 3 episodes" in again.stderr


def test_an_archive_has_the_code_of_its_own_and_says_what_changed_or_lacks(tmp_path, moods, monkeypatch):
    file = tmp_path / "mine.toml"
    file.write_text(FILE.format(1))
    (tmp_path / "pack").mkdir()
    moods(**{"helper_moods": "from pack import SULKS", "pack/__init__": "from pack.words import SULKS"})
    moods(**{"pack/words": "from pathlib import Path\nSULKS = not Path(__file__).with_name('sad.txt').read_text()"})
    (tmp_path / "pack" / "sad.txt").write_text("sad")
    assert llf("study", "run", "mine.toml", "--executor", "here", cwd=tmp_path).returncode == 0
    same = llf("study", "archive", "mine.db", "a.zip", cwd=tmp_path)
    with zipfile.ZipFile(tmp_path / "a.zip") as opened:
        opened.extractall(tmp_path / "a")
    places = ("helper_moods.py", "moods.py", "pack/__init__.py", "pack/sad.txt", "pack/words.py")
    code = tmp_path / "a" / "code"
    assert sorted(f"{path.relative_to(code)}" for path in code.rglob("*.*")) == list(places)
    assert all((code / place).read_bytes() == (tmp_path / place).read_bytes() for place in places)
    assert not re.search("lacks|since this study", same.stderr)
    assert (again := llf("study", "run", "../study.toml", "--executor", "here", cwd=code)).returncode == 0, again.stderr

    (tmp_path / "pack" / "sad.txt").write_text("glad")
    changed = "moods:Grudge has changed since this study was last run (changed: pack.words: sad.txt)"
    commands = (("archive", "mine.db", "b.zip"), ("report", "mine.toml"), ("check", "mine.db"))
    assert all(changed in llf("study", *command, cwd=tmp_path).stderr for command in commands)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr(sys, "path", [each for each in sys.path if not each.startswith(f"{tmp_path}")])
    lacks = llf("study", "archive", "../mine.db", "c.zip", cwd=elsewhere)
    said = "The archive lacks code of moods:Grudge: helper_moods, moods, pack, pack.words, pack.words: sad.txt."
    assert said in lacks.stderr
    with zipfile.ZipFile(elsewhere / "c.zip") as opened:
        assert said in opened.read("README.txt").decode()
        assert not any(name.startswith("code") for name in opened.namelist())


def test_shards_of_different_code_are_not_merged(tmp_path, moods):
    play(tmp_path / "1.db").close()
    moods(helper_moods="SULKS = False")
    play(tmp_path / "2.db").close()
    with pytest.raises(StoreError, match=r"2.db has other code of moods:Grudge than .*1.db \(changed: helper_moods\)"):
        merge(tmp_path / "all.db", [tmp_path / "1.db", tmp_path / "2.db"])


AGENT = """
class Agent:
    def reset(self, docstring):
        pass
    def act(self, observation, feedback):
        return "{}"
"""


def test_the_suite_stops_replays_or_keeps_and_marks_the_card(tmp_path, moods):
    store = tmp_path / "it.db"

    def card(changed="stop"):
        return take("moods:Agent", store, ["advice"], quick=True, workers=1, changed=changed)

    moods(moods=AGENT.format(0))
    first = card()
    moods(moods=f"# The same.\n{AGENT.format(0)}")
    assert card().sentences() == first.sentences()
    moods(moods=AGENT.format(3))
    with pytest.raises(StoreError, match=r"it.db: moods:Agent has changed since .* \(changed: moods\)"):
        card()
    kept = card("keep")
    assert kept.lines == first.lines
    again = card("replay")
    assert again.lines != first.lines
    assert not again.mixed


def test_a_card_of_two_versions_says_so(tmp_path, moods):
    store = tmp_path / "it.db"
    moods(moods=AGENT.format(0))
    take("moods:Agent", store, ["hints"], quick=True, workers=1)
    moods(moods=AGENT.format(1))
    card = take("moods:Agent", store, ["advice", "hints"], quick=True, workers=1, changed="keep")
    assert card.sentences()[0].startswith("Not one result: moods:Agent has changed between episodes, ")
    card.write(tmp_path / "card.json")
    assert Card.load(tmp_path / "card.json").sentences() == card.sentences()
