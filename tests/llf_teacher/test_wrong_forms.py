"""Teachers, environments and studies of a wrong form end before anything is played, with the form that is wanted."""

import sys

import pytest
from commands import llf

import llf_teacher
from llf_teacher.studies import run
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.runner import RunOptions
from llf_teacher.studies.report import findings
from llf_teacher.studies.report.data import read
from llf_teacher.studies.store import Store
from pz_envs.registered import registered
from teachers.personality import PersonalityError, personality

HEAD = """
from dataclasses import dataclass
import gymnasium
from teachers.personality import Personality, Stage, personality

class Echo(Stage):
    def speak(self, claims, view):
        return claims

"""
CLASS = HEAD + "@dataclass(frozen=True)\nclass Mine(Personality):\n    stage = Echo\n    {}\n"
SAYS = HEAD.replace("return claims", "return {}") + "class Mine(Personality):\n    stage = Echo\n"
ENV = (
    HEAD
    + """
class Coin(gymnasium.Env):
    observation_space = gymnasium.spaces.Discrete(2)
    action_space = gymnasium.spaces.Discrete(2)
    def reset(self, {}):
        return {}
    def step(self, action):
        return {}
"""
)
NEEDS = r"wrong_form:Mine: needs must be a frozenset .* as in needs = frozenset\(\{'values'\}\); allowed: .*, got "
SAID = r"teacher 'wrong_form:Mine': wrong_form:Echo \(speak begins in line 7\) must return claims, .* to say nothing"


@pytest.fixture
def write(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    yield (tmp_path / "wrong_form.py").write_text
    sys.modules.pop("wrong_form", None)


def play(path, **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["wrong_form:Mine", "silent"], "students": ["obedient"]}
    study = Study(**(settings | {"seeds": 2, "max_turns": 3} | changes))
    return run(study, path, options=RunOptions("here"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (CLASS.format("needs = ('regret',)"), NEEDS + r"\('regret',\)"),
        (CLASS.format("needs = ['values']"), NEEDS),
        (CLASS.format("needs = 'regret'"), NEEDS),
        (CLASS.format("needs = frozenset({'regrets'})"), NEEDS),
        (CLASS.format("honest = 'no'"), "wrong_form:Mine: honest must be True or False, or a property, got 'no'"),
        (CLASS.format("def mute(self): return True"), "wrong_form:Mine: mute must be True or False, or a property"),
        (CLASS.format("stage = lambda: 3"), "wrong_form:Mine: stage must be a subclass of teachers.personality.Stage"),
        (CLASS.replace("stage = Echo", "pass").format(""), "wrong_form:Mine lacks `stage`: set it to a subclass of"),
        (SAYS.format("'No!'"), SAID + ", got 'No!'"),
        (SAYS.format("['No!']"), SAID + r", got \['No!'\]"),
        (SAYS.format("None"), SAID + ", got None"),
        (SAYS.format("[*claims, 3]"), SAID),
    ],
)
def test_a_personality_of_a_wrong_form_ends_the_study_before_it_plays(tmp_path, write, text, said):
    write(text)
    with pytest.raises(ValueError, match=said):
        play(tmp_path / "s.db")
    assert not (tmp_path / "s.db").exists()


def test_in_a_pipeline_the_stage_is_named(tmp_path, write):
    write(SAYS.format("'No!'"))
    with pytest.raises(ValueError, match=r"teacher 'wrong_form:Mine \| delayed': wrong_form:Echo .* got 'No!'"):
        play(tmp_path / "s.db", teachers=["wrong_form:Mine | delayed", "silent"])


def test_what_has_the_form_is_played(tmp_path, write):
    write(CLASS.format("needs = frozenset({'regret'})\n    @property\n    def honest(self): return False"))
    with play(tmp_path / "s.db") as results:
        assert len(list(results.rows())) == 4


@pytest.mark.parametrize("oracle", [{}, {"options": {"gym:*": {"oracle": "rewards"}}}])
@pytest.mark.parametrize(
    ("parts", "said"),
    [
        (
            ("*, seed=None, options=None", "0, {}", "0, 1.0, True, {}"),
            r"wrong_form:Coin.step must return five values \(observation, reward, terminated, truncated, info\), got 4",
        ),
        (("*, seed=None, options=None", "0, {}", "0"), "wrong_form:Coin.step must return five values .* got a int: 0"),
        (("*, seed=None, options=None", "0", "0, 1.0, True, False, {}"), "Coin.reset must return two values .*, got 0"),
        (("**_", "0, {}", "0, 1.0, True, False"), "Coin.step must return five values .*, got 4 values"),
    ],
)
def test_an_environment_of_a_wrong_form_ends_the_study_before_it_plays(tmp_path, write, parts, said, oracle):
    write(ENV.format(*parts))
    registered.cache_clear()
    try:
        with pytest.raises(ValueError, match=said):
            play(tmp_path / "s.db", ids=["gym:wrong_form:Coin"], teachers=["oracle", "silent"], **oracle)
    finally:
        registered.cache_clear()
    assert not (tmp_path / "s.db").exists()


def test_a_baseline_that_names_no_teacher_is_refused():
    with pytest.raises(ValueError, match="baseline: unknown teacher 'nobody'; allowed: oracle, silent"):
        Study(ids=["llf-gridworld-v0"], teachers=["oracle", "silent"], students=["random"], baseline="nobody")


def test_a_study_whose_episodes_all_failed_says_why_each_time(tmp_path):
    (tmp_path / "tired.py").write_text("class Tired:\n  def act(self, observation):\n    raise ValueError('no')\n")
    (tmp_path / "mine.toml").write_text(
        'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nstudents = ["tired:Tired"]\nseeds = 2\nmax_turns = 2\n'
    )
    command = ("study", "run", "mine.toml", "--executor", "here")
    for said in ("2 of 2 episodes failed, the first: ", "2 of 2 episodes failed in an earlier run, such as "):
        done = llf(*command, cwd=tmp_path)
        assert done.returncode == 3
        assert said in done.stderr
        assert "ValueError('no') (tired.py, line 3)" in done.stderr
        assert "There is no report, since all episodes failed" in done.stderr
        assert "--retry-failed" in done.stderr
        assert not (tmp_path / "mine.html").exists()
    report = llf("study", "report", "mine.toml", cwd=tmp_path)
    assert report.returncode == 2
    assert "2 failed, the first because of ValueError('no') (tired.py, line 3)" in report.stderr


def test_a_teacher_that_errs_otherwise_fails_its_episodes_alone(tmp_path, write):
    write(SAYS.format("claims if view.turn else 1 / 0"))
    with pytest.warns(RuntimeWarning, match="2 of 4 episodes failed, the first: .*ZeroDivisionError"):
        results = play(tmp_path / "s.db", compare=[["wrong_form:Mine", "silent"]])
    with results, Store(tmp_path / "s.db", read_only=True) as store:
        first, *_ = findings(read(store, results.study))
    assert first == (
        "Nothing can be said about wrong_form:Mine and silent: no student that reads what teachers say was taught by "
        "both on the same seeds. 2 of 4 episodes have been played, 2 failed."
    )


def test_what_is_no_claim_is_refused_in_a_lesson():
    @personality()
    def wordy(claims, view):
        return ["No!"]

    env = llf_teacher.make("llf-gridworld-v0", teacher=wordy())
    with pytest.raises(PersonalityError, match=r"test_wrong_forms:.*wordy must return claims, .*, got \['No!'\]"):
        env.reset(seed=0)
