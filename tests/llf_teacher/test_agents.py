"""Agents of the user's own: the three protocols, their specs, and what goes wrong in them."""

import importlib
import sys
import textwrap

import numpy as np
import pytest
from commands import llf

import llf_teacher
from llf_teacher.students.agents import GYMNASIUM, LLF, POLICY, as_text, protocol_of
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import EpisodeError, RunOptions, play_missing
from llf_teacher.studies.store import Store
from teachers.atoms import Utterance

MODULE = """
import numpy as np

LOG = []

class Scripted:
    '''LLF-Bench's protocol; goes where it is told to.'''
    def __init__(self, answer="Response: north", shout=False):
        self.answer = answer
    def reset(self, docstring):
        LOG.append(("reset", docstring))
    def act(self, observation, feedback, **kwargs):
        LOG.append(("act", observation, feedback))
        return self.answer

class Numbers(Scripted):
    '''As LLF-Bench's random agent: any arguments; native actions.'''
    def act(self, *args, **kwargs):
        LOG.append(args)
        return np.int64(2)

class Gym:
    def act(self, observation, deterministic=True):
        LOG.append(observation)
        return "Response: west"

class GymReset(Gym):
    def reset(self):
        LOG.append("reset")

class Ours:
    def reset(self, rng):
        self.rng = rng
    def act(self, observation, info):
        LOG.append((observation, info))
        return int(self.rng.integers(4))

class Reader(Ours):
    reads = "atoms"

class Native(Scripted):
    text = False
    def act(self, observation, feedback):
        LOG.append(observation)
        return 1

def made(kind="Scripted", **options):
    return globals()[kind](**options)

class Breaks(Scripted):
    def act(self, observation, feedback):
        LOG.append(1)
        if len(LOG) == 2:
            raise self.problem()
        return "north"
    def problem(self):
        return KeyError("no idea")

class Unpicklable(Exception):
    def __init__(self, *, response):
        super().__init__(f"no {response}")

class BreaksOddly(Breaks):
    def problem(self):
        return Unpicklable(response="sense")

class Slow(Scripted):
    '''Still plays when another one fails.'''
    def __init__(self, marker):
        self.marker = marker
    def act(self, observation, feedback):
        import pathlib, time
        pathlib.Path(self.marker).touch()
        time.sleep(0.5)
        return "north"

class Impatient(Slow):
    def act(self, observation, feedback):
        import pathlib, time
        while not pathlib.Path(self.marker).exists():
            time.sleep(0.01)
        raise KeyError("now")

class Mute:
    def reset(self, docstring):
        pass

class Three:
    def reset(self, docstring):
        pass
    def act(self, observation, feedback, reward):
        pass

class NoReset:
    def act(self, observation, feedback):
        pass

class GymSeed:
    def reset(self, seed):
        pass
    def act(self, observation):
        pass

class Keyword:
    def act(self, observation, *, feedback):
        pass

class Liar(Scripted):
    reads = "minds"

number = 3
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """The module of this test, by its name."""
    name = f"mine_{tmp_path.name.replace('-', '_')}"
    (tmp_path / f"{name}.py").write_text(textwrap.dedent(MODULE))
    monkeypatch.syspath_prepend(tmp_path)
    return name


def study(*students, **changes):
    settings = {"ids": ["llf-gridworld-v0"], "teachers": ["oracle"], "seeds": 1, "max_turns": 3}
    return Study(students=students, **(settings | changes))


def episode(student, **changes):
    record = play(next(study(student, **changes).episodes()))
    return record, sys.modules[student.partition(":")[0]].LOG


def test_llf_bench_protocol(mine):
    record, log = episode(f"{mine}:Scripted", feedback_types=["hn"])
    assert log[0][0] == "reset"
    assert log[0][1] == record.turns[0].instruction
    assert log[1][2] is None
    assert [entry[1:] for entry in log[2:]] == [(turn.observation, turn.feedback) for turn in record.turns[1:-1]]
    assert all(type(text) is str for entry in log[2:] for text in entry)
    assert record.episode.reads == "words"
    assert record.episode.parse_failures == 0


def test_llf_bench_protocol_with_advice_at_the_opening(mine):
    record, log = episode(f"{mine}:Scripted", feedback_types=["fp"])
    assert log[1][2] == record.turns[0].feedback
    assert not isinstance(log[1][2], Utterance)


def test_native_actions_of_any_agent_are_understood(mine):
    record, log = episode(f"{mine}:Numbers")
    assert len(log[1]) == 2
    assert [turn.action for turn in record.turns[1:]] == ["2"] * 3


def test_gymnasium_protocol(mine):
    record, log = episode(f"{mine}:Gym")
    assert all(set(entry) == {"observation", "instruction", "feedback"} for entry in log)
    assert [entry["instruction"] for entry in log] == [record.turns[0].instruction, "", ""]
    assert [entry["feedback"] for entry in log] == [turn.feedback for turn in record.turns[:-1]]
    assert not any(isinstance(text, Utterance) for entry in log for text in entry.values())


def test_gymnasium_protocol_sees_what_the_environment_gives(mine):
    _, log = episode(f"{mine}:GymReset", seeds=[5])
    env = llf_teacher.make("llf-gridworld-v0", text=True, max_turns=3)
    observations = [env.reset(seed=5)[0], env.step("west")[0], env.step("west")[0]]
    assert log == ["reset", *observations]


def test_policies_play_natively(mine):
    record, log = episode(f"{mine}:Ours")
    assert record == episode(f"{mine}:Ours")[0]
    assert all("atoms" not in info and set(seen) == {"state", "instruction", "feedback"} for seen, info in log)
    assert not isinstance(log[0][0]["feedback"], Utterance)
    record, log = episode(f"{mine}:Reader")
    assert log[-1][1]["atoms"]
    assert record.episode.reads == parse_student(f"{mine}:Reader").reads == "atoms"


def test_an_attribute_makes_it_native(mine):
    record, _ = episode(
        f"{mine}:Native", ids=["llf-bandits-BanditTwoArmedHighLowFixed-v0"], feedback_types=["r"], seeds=[1]
    )
    assert record.turns[1].action == "1"


def test_nonsense_is_a_turn(mine):
    record, _ = episode(f"{mine}:Scripted(answer='I dare not \\ud800 \\x00')")
    assert record.episode.parse_failures == 3
    record, _ = episode(f"{mine}:Scripted(answer=None)")
    assert record.turns[1].parse_failure == "null"


def test_actions_as_text():
    assert as_text(np.array([0.5, -1])) == "[0.5, -1.0]"
    assert as_text({"action": np.float64(2)}) == '{"action": 2.0}'
    assert "object" in as_text(object())
    assert as_text("x\ud800") == "x?"


def test_protocols_by_their_arguments(mine):
    module = importlib.import_module(mine)
    shown = {"Scripted": LLF, "Numbers": LLF, "Gym": GYMNASIUM, "GymReset": GYMNASIUM, "Ours": POLICY, "Reader": POLICY}
    assert {name: protocol_of(getattr(module, name)(), name) for name in shown} == shown


@pytest.mark.parametrize("name", ["Mute", "Three", "NoReset", "GymSeed", "Keyword", "dict"])
def test_an_agent_of_no_protocol_is_refused(mine, name):
    spec = f"{mine}:{name}" if name != "dict" else "builtins:dict"
    with pytest.raises(ValueError, match=r"gave an agent with (no )?reset.*, (no )?act.*; expected reset\(docstring\)"):
        play(next(study(spec).episodes()))


class Awaited:
    def reset(self, docstring):
        pass

    async def act(self, observation, feedback):
        return "north"


class Yielding(Awaited):
    def act(self, observation, feedback):
        yield "north"


@pytest.mark.parametrize(
    ("agent", "kind"), [(Awaited, r"a coroutine function \(`async def`\)"), (Yielding, r"a generator \(`yield`\)")]
)
def test_an_agent_that_acts_later_is_refused_when_a_study_begins(agent, kind):
    message = rf"gave an agent whose act is {kind}; expected a method that returns"
    with pytest.raises(ValueError, match=message):
        parse_student(f"{__name__}:{agent.__name__}").check({})
    with pytest.raises(ValueError, match=message):
        protocol_of(agent(), agent.__name__)


def test_an_agent_that_returns_what_is_to_be_awaited_is_an_error(mine, monkeypatch):
    monkeypatch.setattr(importlib.import_module(mine).Scripted, "act", lambda *_: (each for each in ["north"]))
    with pytest.raises(TypeError, match="act must return an action, got a generator"):
        play(next(study(f"{mine}:Scripted").episodes()))


@pytest.mark.parametrize("spec", ["{}:Scripted", "{}:Scripted(answer='a: b | c', shout=True)", "{}:made(kind='Gym')"])
def test_specs_round_trip(mine, spec):
    spec = spec.format(mine)
    assert str(parse_student(spec)) == spec
    loose = spec.replace(":", " : ", 1).replace("=", " = ")
    assert study(loose).students == (spec,)
    assert parse_student(str(parse_student(loose))) == parse_student(spec)


@pytest.mark.parametrize(
    ("spec", "match"),
    [
        ("no_such_module:Agent", "students: student 'no_such_module:Agent': cannot import the module 'no_such_module'"),
        ("{}:Scriptd", "unknown factory in .* 'Scriptd'; did you mean Scripted"),
        ("{}:number", "unknown factory in .* 'number'"),
        ("{}:Scripted(size=3)", "student '.*:Scripted': unknown parameter 'size'; .*allowed: answer"),
        ("{}:Scripted(answer=open)", "bad student spec .*; expected .*`package.module:factory`"),
        ("{}:Scripted('x')", "bad student spec"),
        ("{}:", "bad student spec"),
        ("{}:a.b", "bad student spec"),
        ("{}:Liar", "unknown value of reads 'minds'; .*allowed: nothing"),
    ],
)
def test_a_bad_spec_is_refused_before_anything_runs(mine, spec, match):
    with pytest.raises(ValueError, match=match):
        study(spec.format(mine))


def test_a_module_that_breaks_is_named(tmp_path, monkeypatch):
    (tmp_path / "broken_module.py").write_text("\n1 / 0")
    monkeypatch.syspath_prepend(tmp_path)
    match = r"cannot import the module 'broken_module': ZeroDivisionError\(.*\) \(broken_module.py, line 2\)$"
    with pytest.raises(ValueError, match=match):
        study("broken_module:Agent")


def test_agents_fit_the_other_door(mine):
    env = llf_teacher.TeacherEnv("llf-gridworld-v0", student=f"{mine}:Scripted", max_turns=2)
    env.reset(seed=0)
    env.step(0)
    env.step(0)
    assert [entry[0] for entry in sys.modules[mine].LOG] == ["reset", "act", "act"]


@pytest.mark.parametrize(
    ("student", "match"),
    [
        ("Breaks", r"episode .*'seed': 0.* failed: KeyError\('no idea'\)"),
        ("BreaksOddly", r"failed: Unpicklable\('no sense'\)"),
    ],
)
def test_what_was_played_before_a_failure_is_stored(mine, tmp_path, student, match):
    with Store(tmp_path / "s.db") as store:
        with pytest.raises(EpisodeError, match=match) as caught:
            play_missing(study("random", f"{mine}:{student}"), store, workers=1, options=RunOptions("processes"))
        assert "raise self.problem()" in caught.value.trace
        assert [row["student"] for row in store.episodes()] == ["random"]


def test_what_is_being_played_at_a_failure_is_stored_and_no_more_is_begun(mine, tmp_path):
    students = [f"{mine}:{name}(marker={str(tmp_path / 'marker')!r})" for name in ("Slow", "Impatient")]
    with Store(tmp_path / "s.db") as store:
        more = (f"{mine}:Scripted(answer='{n}')" for n in range(20))
        with pytest.raises(EpisodeError, match="KeyError"):
            play_missing(study(*students, *more), store, workers=2, options=RunOptions(fail_fast=True))
        stored = [row["student"] for row in store.episodes()]
    assert students[0] in stored
    assert len(stored) < 10


def test_the_command_line(tmp_path):
    (tmp_path / "my_agent.py").write_text(MODULE)
    file = tmp_path / "study.toml"

    def run_with(student):
        file.write_text(
            f'ids = ["llf-gridworld-v0"]\nteachers = ["oracle"]\nstudents = ["random", "{student}"]\nseeds = 1\n'
        )
        return llf("study", "run", "study.toml", "--store", "s.db", "--workers", "1", cwd=tmp_path)

    refused = run_with("my_agent:Scriptd")
    assert refused.returncode == 2
    assert "did you mean Scripted" in refused.stderr
    assert not (tmp_path / "s.db").exists()
    failed = run_with("my_agent:Breaks")
    assert failed.returncode == 3
    assert 'my_agent.py", line' in failed.stderr
    assert "llf: episode {'id': 'llf-gridworld-v0'" in failed.stderr
    assert "The same command with --retry-failed plays the failed episodes again" in failed.stderr
    assert "Played 1 episodes; s.db now has 1." in failed.stderr
    assert "runner.py" not in failed.stderr.partition("llf: episode")[2]
    played = run_with("my_agent:Scripted(answer='west')")
    assert played.returncode == 0, played.stderr
    assert "Played 1 episodes" in played.stderr
    assert "my_agent:Scripted(answer=&#39;west&#39;)</code><small>reads words" in (tmp_path / "study.html").read_text(
        encoding="utf-8"
    )
