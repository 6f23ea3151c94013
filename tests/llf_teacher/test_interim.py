"""A study with interim analyses is played step by step, reports each decision, and may end early."""

from dataclasses import replace

import pytest
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.studies.definition.study import Study, load_study, to_toml
from llf_teacher.studies.execution.runner import RunOptions, Shard, play_missing
from llf_teacher.studies.report import render
from llf_teacher.studies.report.data import read
from llf_teacher.studies.store import Store

HERE = RunOptions("here")
ENDS = Study(
    ids=["llf-gridworld-v0"],
    teachers=["oracle", "silent"],
    students=["obedient"],
    seeds=24,
    max_turns=6,
    interim_analyses={"at": [2, 12, 24], "spending": "pocock", "stop": True},
)


def played(study, path, options=HERE):
    """Number of episodes that a run plays, and its decisions."""
    told = []
    with Store(path) as store:
        return play_missing(study, store, options=options, on_interim=told.append), [f"{each}" for each in told]


def test_a_study_ends_where_all_is_found_and_is_final_then(tmp_path):
    path = tmp_path / "s.db"
    number, told = played(ENDS, path)
    assert number == 2 * 12
    assert [line[:42] for line in told] == [
        "Interim analysis 1 of 3, after 2 seeds: 0 ",
        "Interim analysis 2 of 3, after 12 seeds: 1",
    ]
    assert told[0].endswith(
        "of 1 primary comparisons are significant, adjusted for the analyses and by Holm's method (p <= 0.05); "
        "the study goes on."
    )
    assert told[1].endswith("the study ends here, as it declares.")
    data = read(Store(path), ENDS)
    assert data.stopped
    assert data.final
    html = render(Store(path), ENDS)
    assert "This study has ended at interim analysis 2 of 3" in html
    assert "not final" not in html
    assert played(ENDS, path) == (0, told[1:]), "the same command plays no more"

    on = replace(ENDS, interim_analyses={**ENDS.interim_analyses, "stop": False})
    assert not read(Store(path), on).final
    number, told = played(on, path, RunOptions("processes"))
    assert number == 2 * 12
    assert told[-1].endswith("; it was the last.")
    assert read(Store(path), on).final


def test_it_goes_on_as_long_as_something_may_be_found(tmp_path):
    placebo = replace(ENDS, teachers=("oracle", "placebo", "silent"), seeds=tuple(range(4)), interim_analyses={})
    study = replace(placebo, interim_analyses={"at": [2, 4], "stop": True})
    number, told = played(study, tmp_path / "s.db")
    assert number == 3 * 4
    assert len(told) == 2
    assert not read(Store(tmp_path / "s.db"), study).stopped


def test_shards_cannot_decide(tmp_path):
    with pytest.raises(ValueError, match=r"may stop it cannot be played in shards, got shard 1/2; .* leave out `stop`"):
        played(ENDS, tmp_path / "s.db", RunOptions("here", shard=Shard(1, 2)))
    on = replace(ENDS, interim_analyses={**ENDS.interim_analyses, "stop": False})
    assert played(on, tmp_path / "s.db", RunOptions("here", shard=Shard(1, 2))) == (24, [])


def test_the_command_says_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(to_toml(ENDS))
    assert load_study(tmp_path / "study.toml") == ENDS
    result = CliRunner().invoke(app, ["study", "run", "study.toml", "--executor", "here"], env={"COLUMNS": "300"})
    assert result.exit_code == 0, result.output
    assert "Interim analysis 2 of 3, after 12 seeds: 1 of 1 primary comparisons are significant" in result.output
    assert "Played 24 episodes" in result.output
