"""What went wrong in a study is said at the head of its report, and at the end of a run."""

import re
import sys

import pytest
from studying import stored
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.episodes.failure import Failure
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.report import render
from llf_teacher.studies.store import Store

STUDY = Study(
    ids=("llf-gridworld-v0",), teachers=("oracle", "silent"), students=("random", "obedient"), seeds=3, max_turns=3
)


def head_of(html):
    return " ".join(re.sub(r"<[^>]*>", "", html[html.index("<main>") : html.index("<nav")]).split())


def test_failures_are_counted_by_student_and_reason(tmp_path):
    specs = list(STUDY.episodes())
    with Store(tmp_path / "s.db") as store:
        for spec in specs[:-3]:
            store.add(play(spec))
        for spec, reason in zip(specs[-3:], ("raised", "raised", "time"), strict=True):
            store.add_failure(spec, Failure(reason, "Boom()"))
        store.add_failure(specs[-1]._replace(seed=99), Failure("raised", "of another study"))
        head = head_of(render(store, STUDY))
    assert "9 of its 12 episodes have been played" in head
    assert "3 episodes of obedient failed (raised: 2, time: 1), and are left out of all figures." in head


def test_without_trouble_nothing_is_said(tmp_path):
    html = render(Store(stored(tmp_path / "s.db", STUDY)), STUDY)
    assert "failed" not in head_of(html)
    assert "No answer" not in html


MUTE = """
class Mute:
    def reset(self, docstring):
        pass

    def act(self, observation, feedback):
        return "I would rather not say."


def agent():
    return Mute()
"""


@pytest.fixture
def mute(tmp_path, monkeypatch):
    (tmp_path / "mute_agents.py").write_text(MUTE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    yield "mute_agents:agent"
    sys.modules.pop("mute_agents", None)


def test_a_student_who_cannot_be_read_is_warned_of(mute, tmp_path):
    (tmp_path / "study.toml").write_text(
        f'ids = ["llf-gridworld-v0"]\nteachers = ["oracle", "silent"]\nstudents = ["{mute}", "obedient"]\nseeds = 2\n'
        "max_turns = 3\n"
    )
    result = CliRunner().invoke(
        app, ["study", "run", "study.toml", "--executor", "here", "--store", "s.db", "--report", "r.html"]
    )
    assert result.exit_code == 0, result.output
    assert f"warning: no answer of {mute} could be read as an action" in result.output
    assert "warning: no answer of obedient" not in result.output
    head = head_of((tmp_path / "r.html").read_text(encoding="utf-8"))
    assert f"No answer of {mute} could be read as an action." in head
