"""The benchmark times every form on fresh work; how fast they are is not a matter of tests."""

import gc
import os
import pickle
import shutil
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console
from typer.testing import CliRunner

import llf_teacher
from llf_teacher.cli import app
from llf_teacher.registry import PREFIX
from llf_teacher.tools import benchmark
from llf_teacher.tools.benchmark import equality, measuring, player, speed, timings
from llf_teacher.tools.benchmark.measuring import Call, Measured, Player, Writer, measure, ratio
from llf_teacher.tools.benchmark.player import FORMS, Times
from pz_envs.family import all_families

GRID = "llf-gridworld-v0"
INSTALLED = Path(llf_teacher.__file__).parents[1]
"""Where the packages are."""


class Here:
    """Plays in this process, which is at hand."""

    def __init__(self, call, tree):
        self.call = call

    def play(self, scripts):
        return FORMS[self.call.form](scripts, *self.call.arguments)

    def close(self):
        """Nothing was begun."""


@pytest.fixture
def little(monkeypatch):
    monkeypatch.setattr(measuring, "Player", Here)
    monkeypatch.setattr(measuring, "BLOCKS", 2)
    monkeypatch.setattr(timings, "BLOCKS", 2)
    monkeypatch.setattr(timings, "_STEPS", 10)
    monkeypatch.setattr(timings, "_STEPS_OF_ORIGINALS", 5)


def text_of(table):
    console = Console(width=200)
    with console.capture() as captured:
        console.print(table)
    return captured.get()


def family(name):
    return next(family for family in all_families() if family.name == name)


def copy(folder, file, old, new):
    """The packages, but for one change."""
    for package in ("worlds", "teachers", "pz_envs", "llf_teacher"):
        shutil.copytree(INSTALLED / package, folder / package)
    code = (folder / file).read_text()
    assert code.count(old) == 1
    (folder / file).write_text(code.replace(old, new))


def said(what):
    """Nobody is told what comes next."""


def test_no_seed_and_no_action_is_played_twice():
    writer = Writer(GRID, "random")
    scripts = writer.write(50) + writer.write(50)
    assert sum(len(actions) for _, actions in scripts) == 100
    assert len({seed for seed, _ in scripts}) == len(scripts)
    assert len({tuple(actions) for _, actions in scripts}) == len(scripts)


def test_advised_actions_lead_to_success_and_no_further():
    import llf_teacher

    for seed, actions in Writer(GRID, "obedient").write(60)[:-1]:  # the last is cut short
        env = llf_teacher.make(GRID)
        env.reset(seed=seed)
        successes = [env.step(action)[4]["success"] for action in actions]
        assert successes.index(True) == len(actions) - 1


def test_steps_are_timed_with_and_without_teaching(little):
    text = text_of(benchmark.steps([family("gridworld")], said, 1))
    for name in ("random", "advised"):
        (row,) = (line.split() for line in text.splitlines() if f"{GRID} " in line and f" {name} " in line)
        assert len(row) == 11


def test_worlds_are_beside_the_originals_where_there_are_any(little):
    text = text_of(benchmark.worlds([family("gridworld"), family("parking")], said, 1))
    mine, highway = (line.split() for line in text.splitlines() if line.startswith(PREFIX))
    assert len(mine) == 2
    assert float(highway[-1]) < 1


def test_every_form_is_timed(little, monkeypatch):
    monkeypatch.setattr(timings, "simple_families", lambda: [family("gridworld")])
    text = text_of(benchmark.forms(said, 1))
    for form in (
        "raw_env",
        "env",
        "StudentEnv",
        "TeacherEnv",
        "ClassroomEnv(1)",
        "ClassroomEnv(8)",
        "ClassroomEnv(64)",
    ):
        assert text.count(f" {form} ") == len(timings.STUDENTS)


def test_seats_are_timed_with_all_that_is_said_and_with_nothing(little):
    text = text_of(benchmark.seats([family("gridworld")], said, 1))
    rows = [line.split() for line in text.splitlines() if line.startswith(PREFIX)]
    assert [row[:2] for row in rows] == [["llf-gridworld-v0", name] for name in timings.STUDENTS]
    assert all(float(row[2]) > 0 and row[7].endswith("%") for row in rows)


def test_a_figure_is_the_median_of_the_runs_with_their_range(monkeypatch):
    seconds = {"tictactoe": [2, 2, 2, 2, 2], "all": [5, 4, 9, 8, 1], "none": [5, 2, 6, 2, 1]}
    runs = iter(zip(*seconds.values(), strict=True))
    monkeypatch.setattr(
        measuring, "measure", lambda calls, scripts: dict(zip(calls, map(times, next(runs)), strict=True))
    )
    monkeypatch.setattr(timings, "STUDENTS", {"random": "random"})
    monkeypatch.setattr(timings, "blocks_of", lambda id, student, steps: [])
    row = text_of(benchmark.seats([family("gridworld")], said)).splitlines()[-1]
    assert "5,000,000 (1,000,000 to 9,000,000)" in row
    assert "0.40 (0.22 to 2.00)" in row
    assert " 33% " in row  # of 0, 1/2, 1/3, 3/4 and 0
    assert next(runs, None) is None


def test_a_process_that_dies_is_an_error():
    player = Player(Call("student", ("llf-nowhere-v0", "a")))
    with pytest.raises(RuntimeError, match=r"the process that plays Call.* has ended"):
        player.play([(0, [0])])
    player.close()


def times(*seconds):
    return Measured([Times([0.0] * 10, [0.0], each * 10, 0.0) for each in seconds])


def test_a_ratio_has_the_interval_of_its_logarithm():
    mean, low, high = ratio(times(2, 4, 2, 4), times(1, 1, 1, 1))
    assert mean == pytest.approx(8**0.5)
    assert low == pytest.approx(1.4962, abs=1e-3)  # exp(1.0397 - 3.182 * 0.4002 / 2)
    assert mean / low == pytest.approx(high / mean)
    assert not benchmark.Speed(GRID, "", ratio(times(1, 1.01, 1), times(1, 1, 1))).slower
    assert benchmark.Speed(GRID, "", ratio(times(2, 2.02, 2), times(1, 1, 1))).slower


def test_the_turns_of_a_study_are_timed():
    times = Times(*FORMS["study"]([(3, []), (4, [])], GRID, "obedient"))
    assert len(times.steps) >= 2
    assert times.cpu > 0


def test_all_that_users_call_is_compared(monkeypatch):
    monkeypatch.setattr(speed, "measure", lambda calls, scripts: {name: times(1, 1.01, 1) for name in calls})
    monkeypatch.setattr(speed, "blocks_of", lambda id, student, steps: [])
    found = list(benchmark.compare_speed([family("gridworld")], str(INSTALLED), said, everything=True))
    names = ("all feedback", "no feedback", "raw_env", "TeacherEnv", "study")
    assert [each.work for each in found] == [f"{kind} actions, {name}" for kind in timings.STUDENTS for name in names]
    result = CliRunner().invoke(app, ["dev", "benchmark", "--all"])
    assert result.exit_code == 2
    assert "--all needs --against" in result.output
    result = CliRunner().invoke(app, ["dev", "benchmark", "--against", "HEAD~1", "--runs", "2"])
    assert result.exit_code == 2
    assert "--runs is for the tables" in result.output
    result = CliRunner().invoke(app, ["dev", "benchmark", "--limit", "1.1"])
    assert result.exit_code == 2
    assert "--limit needs --against" in result.output


def test_the_limit_is_given(monkeypatch):
    monkeypatch.setattr(
        speed, "measure", lambda calls, scripts: {"here": times(1.15, 1.16, 1.15), "there": times(1, 1, 1)}
    )
    monkeypatch.setattr(speed, "blocks_of", lambda id, student, steps: [])
    for limit, slower in ((1.1, True), (1.2, False)):
        found = benchmark.compare_speed([family("gridworld")], str(INSTALLED), said, limit=limit)
        assert {each.slower for each in found} == {slower}


def test_a_process_answers():
    player = Player(Call("lake"))
    steps, *_ = player.play([(0, [1, 2])])
    assert len(steps) == 2
    player.close()


def test_what_a_block_leaves_behind_is_not_collected_in_the_next(monkeypatch):
    monkeypatch.setitem(FORMS, "generations", lambda: gc.get_count())
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=BytesIO(pickle.dumps(("generations", ())))))
    monkeypatch.setattr(sys, "stdout", SimpleNamespace(buffer=BytesIO()))
    answers = sys.stdout.buffer
    gc.collect(1)  # from which the next older generation counts one more
    player.main()
    assert pickle.loads(answers.getvalue())[2] == 0


def test_what_seems_slower_is_played_once_more(monkeypatch):
    """Of four kinds of work the first seems slower once, the second twice; the others are as fast."""
    slow, same = times(2, 2.02, 2), times(1, 1.01, 1)
    measured = iter([slow, same, slow, slow, same, same])
    monkeypatch.setattr(speed, "measure", lambda calls, scripts: {"here": next(measured), "there": times(1, 1, 1)})
    monkeypatch.setattr(speed, "blocks_of", lambda id, student, steps: [])
    (grid,) = (family for family in all_families() if PREFIX + family.showcase[0] == GRID)
    assert [each.slower for each in benchmark.compare_speed([grid], str(INSTALLED), said)] == [
        False,
        True,
        False,
        False,
    ]
    assert list(measured) == []


def test_what_is_no_installation_is_refused():
    with pytest.raises(ValueError, match=r"'no-such-thing' is neither a folder .* nor a revision"):
        next(benchmark.compare_speed([], "no-such-thing", said))


def test_work_is_played_by_the_installation_that_is_named(tmp_path):
    """A tree of its own, in which everything is refused."""
    (tmp_path / "llf_teacher").mkdir()
    (tmp_path / "llf_teacher" / "__init__.py").write_text("raise SystemExit(7)")
    blocks = {"there": [Writer(GRID, "random").write(1)]}
    with pytest.raises(RuntimeError, match="has ended"):
        measure({"there": (Call("student", (GRID, "a")), tmp_path)}, blocks)


def test_the_same_code_says_the_same():
    (found,) = equality.compare([GRID], ["mistake(eps=0.5)"], str(INSTALLED), 3, 4, said)
    assert found[:3] == (GRID, "mistake(eps=0.5)", 3)
    assert 6 <= found.turns <= 15  # with the resets
    assert found[4:] == (0, None)


def test_the_last_bit_of_a_claim_is_compared(tmp_path):
    copy(
        tmp_path,
        "teachers/oracles/bandits.py",
        "mean=round(truth.means[arm], 3)",
        "mean=round(truth.means[arm], 3) * (1 + 2**-52)",
    )
    command = [
        "dev",
        "compare",
        str(tmp_path),
        "llf-bandits-BanditTenArmedGaussian-v0",
        "--episodes",
        "4",
        "--turns",
        "2",
    ]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 1
    assert "oracle, seed 100001, turn 0" in result.stdout
    assert "TriedPoor" in result.stdout


@pytest.mark.full
def test_a_slowed_copy_fails_and_the_other_way_round_passes(tmp_path):
    line = "        self._running = not (session.terminated or session.truncated)\n"
    copy(tmp_path, "llf_teacher/gym/student_env.py", line, line + "        sum(range(4000))\n")

    def judged(mine, other):
        command = [sys.executable, "-m", "llf_teacher", "dev", "benchmark", "gridworld", "--against", str(other)]
        environment = os.environ | {"PYTHONPATH": str(mine)}
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)

    slow, fast = judged(tmp_path, INSTALLED), judged(INSTALLED, tmp_path)
    assert slow.returncode == 1, slow.stdout + slow.stderr
    assert slow.stdout.count("SLOWER") == 4
    assert fast.returncode == 0, fast.stdout + fast.stderr
    assert "SLOWER" not in fast.stdout
