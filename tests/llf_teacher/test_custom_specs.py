"""Teachers and students of one's own in studies."""

import os
import sys
from dataclasses import dataclass

import gymnasium
import pytest
from commands import llf

import llf_teacher
from llf_teacher.registry import family
from llf_teacher.speakers.parsing import parse_teacher
from llf_teacher.studies import run
from llf_teacher.studies.definition.custom_specs import check_portable, student_spec, teacher_spec
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.limits import Limits
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.tools.audit import audit
from llf_teacher.tools.film import film
from llf_teacher.web.lesson import PlannedLesson
from llf_teacher.web.plan import read_plan
from teachers.personalities.delayed import Delayed
from teachers.personality import Personality, Pipeline, Stage, parse_personality

MODULE = '''
from dataclasses import dataclass
from teachers.personality import Personality, Stage, personality


class _Naps(Stage):
    def begin(self):
        self.turn = 0

    def speak(self, claims, view):
        self.turn += 1
        return () if self.turn % self.spec.naps == 0 else claims


@dataclass(frozen=True)
class Sleepy(Personality):
    naps: int = 2
    who: object = "me"
    stage = _Naps

    def __post_init__(self):
        if self.naps < 1:
            raise ValueError(f"naps must be at least 1, got {self.naps}")


@personality()
def terse(claims, view, *, n: int = 1):
    """Says n things."""
    return claims[:n]


class Counted:
    made = 0

    def __init__(self):
        Counted.made += 1

    def act(self, observation):
        return "0"


class Mumbler:
    def __init__(self, word="Mm."):
        self.word = word

    def reset(self, rng):
        pass

    def act(self, observation, info):
        return self.word


class Fixed:
    def act(self, observation):
        return "0"


def outer():
    @personality()
    def inner(claims, view):
        """Says all."""
        return claims

    return inner()
'''


@pytest.fixture
def mine(tmp_path, monkeypatch):
    (tmp_path / "sleepers.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    yield __import__("sleepers")
    del sys.modules["sleepers"]


def test_an_object_is_kept_as_text_that_finds_it(mine):
    assert teacher_spec(mine.Sleepy()) == "sleepers:Sleepy"
    assert teacher_spec(mine.Sleepy(naps=3)) == "sleepers:Sleepy(naps=3)" == teacher_spec("sleepers: Sleepy( naps=3 )")
    assert parse_teacher("sleepers:Sleepy(naps=3)") == mine.Sleepy(naps=3)
    assert parse_teacher("sleepers:terse(n=2)") == mine.terse(n=2)


def test_it_stands_in_a_row_with_others(mine):
    text = "sleepers:Sleepy(who='a | b') | delayed(turns=2) | sleepers:terse"
    row = mine.Sleepy(who="a | b") | Delayed(turns=2) | mine.terse()
    assert parse_teacher(text) == row == Pipeline((mine.Sleepy(who="a | b"), Delayed(turns=2), mine.terse()))
    assert teacher_spec(row) == text


@pytest.mark.parametrize("spec", ["mistake( eps = 0.5 )", "vague | delayed(turns=2)"])
def test_names_of_the_shelf_are_read_as_ever(spec):
    assert parse_teacher(spec) == parse_personality(spec)
    assert teacher_spec(spec) == str(parse_personality(spec))


def test_every_door_takes_them(mine, monkeypatch, tmp_path):
    """`make`, `teach`, the teacher's seat, PettingZoo, films, audits: a spec is the same as the object."""
    monkeypatch.chdir(tmp_path)
    id, spec, own = "llf-gridworld-v0", "sleepers:Sleepy(naps=1) | delayed(turns=2)", mine.Sleepy(naps=1) | Delayed(2)

    def said(env):
        env.reset(seed=3)
        return env.session.teacher.personality

    lake = {"env": lambda: gymnasium.make("FrozenLake-v1"), "oracle": "auto"}
    for teacher in (spec, own):
        assert said(llf_teacher.make(id, teacher=teacher)) == own
        assert said(llf_teacher.teach(**lake, teacher=teacher)) == own
        assert said(llf_teacher.TeacherEnv(id, teacher=teacher)) == own
        assert family("gridworld").raw_env(teacher=teacher).session.teacher.personality == own
        assert audit(id, teacher, turns=4, students=["random"], instruction_types=["b"]).teacher == spec
        assert len(film(id, student="random", seed=1, teacher=teacher, max_turns=1)) == 2
    assert parse_personality(f"drifting(after=1, to={spec!r})").to == spec
    observation, _ = llf_teacher.make(id, teacher="oracle | voice(tone='warm')").reset(seed=1)
    assert observation["feedback"] == llf_teacher.make(id, voice="warm").reset(seed=1)[0]["feedback"]
    with pytest.raises(ValueError, match=r"teacher oracle \| voice.* has a voice of its own, got voice='curt'"):
        llf_teacher.make(id, teacher="oracle | voice(tone='warm')", voice="curt")


def test_a_policy_is_named_in_the_students_environments_alone(mine):
    env = llf_teacher.make("llf-gridworld-v0", teacher="sleepers:Mumbler(word='Hm.')", max_turns=1)
    env.reset(seed=1)
    assert env.step(0)[0]["feedback"] == "Hm."
    assert audit("llf-gridworld-v0", "sleepers:Mumbler", turns=4, students=["random"]).checked == 0
    silent = llf_teacher.make("llf-gridworld-v0", teacher="sleepers:Mumbler", feedback_type="n", max_turns=1)
    silent.reset(seed=1)
    assert silent.step(0)[0]["feedback"] == ""
    with pytest.raises(ValueError, match=r"teacher sleepers:Mumbler speaks for itself, .* needs a personality"):
        llf_teacher.TeacherEnv("llf-gridworld-v0", teacher="sleepers:Mumbler")


@pytest.mark.parametrize(
    "command",
    [
        ("play", "llf-gridworld-v0", "--student", "obedient", "--seed", "1", "--max-turns", "1"),
        ("play", "llf-gridworld-v0", "--seed", "1", "--max-turns", "1"),
        ("film", "llf-gridworld-v0", "film.gif", "--max-turns", "1"),
        ("audit", "llf-gridworld-v0", "--turns", "4"),
        ("teach", "gym:FrozenLake-v1"),
    ],
    ids=lambda command: " ".join(command[:4]),
)
def test_every_command_takes_them(mine, monkeypatch, tmp_path, command):
    monkeypatch.chdir(tmp_path)
    done = llf(*command, "--teacher", "sleepers:Sleepy(naps=1) | delayed(turns=2)", text="north\n")
    assert done.returncode == 0, done.stderr
    refused = llf(*command, "--teacher", "sleepers:Sleepyy", text="north\n")
    assert refused.returncode == 2
    assert "unknown personality in sleepers 'Sleepyy'; did you mean Sleepy" in refused.stderr


def test_the_page_takes_those_that_its_server_offers(mine):
    own = ("sleepers:Sleepy", "sleepers:Fixed")
    given = {"id": "llf-gridworld-v0", "seat": "watch", "seed": 1, "max_turns": 2}
    plan = read_plan(given | {"teacher": "sleepers:Sleepy(naps=1)", "student": "sleepers:Fixed"}, own=own)
    assert PlannedLesson(plan).session.teacher.personality == mine.Sleepy(naps=1)
    del sys.modules["sleepers"]
    for what, spec in (("teacher", "vague | sleepers:terse"), ("student", "sleepers:Counted")):
        with pytest.raises(ValueError, match=rf"unknown {what} of this page .* `llf serve --{what} sleepers:\w+`"):
            read_plan(given | {what: spec}, own=own)
    assert "sleepers" not in sys.modules
    sys.modules["sleepers"] = mine


def test_they_teach_in_a_study(mine):
    study = Study(
        ids=["llf-gridworld-v0"],
        teachers=[mine.Sleepy(naps=1), "sleepers:terse", "silent"],
        students=[mine.Fixed, "obedient"],
        baseline=mine.Sleepy(naps=1),
        seeds=1,
    )
    assert study.teachers == ("sleepers:Sleepy(naps=1)", "sleepers:terse", "silent")
    assert study.students == ("sleepers:Fixed", "obedient")
    assert study.baseline == "sleepers:Sleepy(naps=1)"
    said = {(record.spec.teacher, record.spec.student): record.episode.claims for record in map(play, study.episodes())}
    assert said["sleepers:Sleepy(naps=1)", "obedient"] == 0 < said["sleepers:terse", "obedient"]
    assert said["sleepers:terse", "sleepers:Fixed"] > 0


@pytest.mark.parametrize(
    ("spec", "match"),
    [
        ("nowhere:Sleepy", "teacher 'nowhere:Sleepy': cannot import the module 'nowhere': ModuleNotFoundError"),
        ("sleepers:Sleeper", "unknown personality in sleepers 'Sleeper'; did you mean Sleepy"),
        ("sleepers:Fixed", "unknown personality in sleepers 'Fixed'"),
        ("sleepers:Sleepy(", "bad teacher spec 'sleepers:Sleepy\\('"),
        ("sleepers:Sleepy(1)", r"bad teacher spec .*; expected .*`package\.module:Class\(key=value\)`"),
        ("sleepers:Sleepy(nap=1)", "personality 'sleepers:Sleepy': unknown parameter 'nap'; did you mean naps"),
        ("sleepers:Sleepy(naps=0)", "naps must be at least 1, got 0"),
        ("oracle:", "bad teacher spec 'oracle:'"),
        (3, "bad teacher spec 3"),
    ],
)
def test_a_bad_one_is_refused(mine, spec, match):
    with pytest.raises(ValueError, match=match):
        Study(ids=["llf-gridworld-v0"], teachers=[spec], students=["random"])


def test_what_no_text_finds_is_refused(mine):
    with pytest.raises(ValueError, match="cannot be found by its name; define it in a module, outside functions"):
        teacher_spec(mine.outer())
    with pytest.raises(ValueError, match=r"its spec .* does not lead to it"):
        teacher_spec(mine.Sleepy(who=object()))
    with pytest.raises(ValueError, match="cannot be found by its name"):
        student_spec(lambda: None)


class _Mute(Stage["Shy"]):
    def speak(self, claims, view):
        return ()


@dataclass(frozen=True)
class Shy(Personality):
    """Says nothing."""

    stage = _Mute


def test_a_notebooks_own_is_for_this_process_alone(monkeypatch):
    monkeypatch.setattr(sys.modules["__main__"], "Shy", Shy, raising=False)
    monkeypatch.setattr(Shy, "__module__", "__main__")
    study = Study(ids=["llf-gridworld-v0"], teachers=[Shy(), "oracle"], students=["obedient"], seeds=1)
    assert study.teachers[0] == "__main__:Shy"
    assert [play(spec).episode.claims > 0 for spec in study.episodes()] == [False, True]
    with pytest.raises(
        ValueError,
        match=r"^vague \| __main__:Shy, __main__:f\(\), drifting\(.*\): other processes .* play here, by workers=1",
    ):
        check_portable(
            [*study.teachers[1:], "vague | __main__:Shy", "__main__:f()", "drifting(to='__main__:x')", "random"]
        )
    check_portable(["oracle", "llf_teacher.__main__:x", "random | stubborn(p=1)"])


def test_it_is_refused_before_anything_runs_and_played_here(monkeypatch, tmp_path):
    monkeypatch.setattr(sys.modules["__main__"], "Shy", Shy, raising=False)
    monkeypatch.setattr(Shy, "__module__", "__main__")
    study = Study(ids=["llf-gridworld-v0"], teachers=[Shy()], students=["obedient"], seeds=1, max_turns=2)
    for workers, options in (
        (2, RunOptions()),
        (None, RunOptions()),
        (1, RunOptions("processes")),
        (1, RunOptions(limits=Limits(turn_seconds=9))),
    ):
        with pytest.raises(
            ValueError, match=r"__main__:Shy: other processes cannot .* by workers=1 without limits, or by RunOptions"
        ):
            run(study, tmp_path / "s.db", workers, options=options)
        assert not (tmp_path / "s.db").exists()
    for number, (workers, options) in enumerate(
        [(1, RunOptions()), (None, RunOptions("here")), (1, RunOptions("threads"))]
    ):
        results = run(study, tmp_path / f"{number}.db", workers, options=options)
        assert [(row["teacher"], row["claims"]) for row in results.rows()] == [("__main__:Shy", 0)]


def test_one_worker_plays_here_and_leaves_everything_as_it_was(mine, tmp_path):
    import random

    import numpy as np

    study = Study(ids=["llf-gridworld-v0"], teachers=["silent"], students=[mine.Counted], seeds=2, max_turns=2)

    def everything():
        return random.getstate(), np.random.get_state()[2:], dict(os.environ)  # noqa: NPY002 (whether it is left alone)

    before = everything()
    run(study, tmp_path / "s.db", workers=1)
    assert mine.Counted.made == 2, "in this process"
    assert everything() == before
    run(study, tmp_path / "t.db", workers=1, options=RunOptions("processes"))
    assert mine.Counted.made == 2
