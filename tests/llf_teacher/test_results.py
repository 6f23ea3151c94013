"""What a store holds, for scripts, notebooks and other programs."""

import csv
import io
import itertools
import json
import pkgutil
import sys
from importlib import import_module

import pandas
import pytest
from pyarrow import parquet
from typer.testing import CliRunner

from llf_teacher import studies
from llf_teacher.cli import app
from llf_teacher.studies import Study, load, read_csv, results, run
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.report.figure import Plot
from llf_teacher.studies.store import StoreError

STUDY = Study(
    ids=["llf-gridworld-v0", "llf-poem-Haiku-v0"],
    teachers=["oracle", "mistake(eps=1)"],
    students=["text_only", "random"],
    seeds=2,
    max_turns=4,
)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    return run(STUDY, tmp_path_factory.mktemp("results") / "s.db", workers=1)


def test_a_study_is_one_call(found):
    assert repr(found).endswith("s.db', 16 episodes)")
    assert found.manifest["study"]["seeds"] == [0, 1]
    assert [row["key"] for row in load(f"{found.path}").rows()] == [spec.key for spec in STUDY.episodes()]


def test_one_function_runs_a_study():
    modules = [module.name for module in pkgutil.walk_packages(studies.__path__, f"{studies.__name__}.")]
    found = {vars(import_module(name)).get("run") for name in modules if not name.endswith(".ray")}
    assert found == {None, run}


def test_episodes_are_a_table_of_what_is_installed(found, monkeypatch):
    frame = found.episodes
    assert isinstance(frame, pandas.DataFrame)
    records = [play(spec) for spec in STUDY.episodes()]
    assert frame.regret.tolist() == [record.episode.regret for record in records]
    assert frame.regrets.tolist() == [[turn.regret for turn in record.turns[1:]] for record in records]
    assert frame.success.dtype == bool
    monkeypatch.setitem(sys.modules, "pandas", None)
    monkeypatch.setitem(sys.modules, "polars", None)
    assert found.episodes == list(found.rows())


def test_a_transcript_tells_what_was_seen_said_and_done(found):
    row = next(row for row in found.rows() if row["teacher"] == "mistake(eps=1)" and row["student"] == "text_only")
    turns, text = found.turns(row["key"]), found.transcript(row["key"])
    assert text.count("student: ") == row["turns"] == len(turns) - 1
    assert all(atom["text"] in text for turn in turns for atom in turn["atoms"])
    assert text.count("!: ") == row["claims"] - row["claims_held"] > 0


def test_a_transcript_is_found_by_the_beginning_of_its_key(found):
    keys = sorted(row["key"] for row in found.rows())
    unique = next(n for n in range(1, 33) if len({key[:n] for key in keys}) == len(keys))
    for key in keys:
        assert found.transcript(key[:unique]) == found.transcript(key.upper()) == found.transcript(key)
    for none in ("00" * 16, "no key"):
        message = f"has no episode whose key begins with '{none}'; `llf study export` writes all keys"
        with pytest.raises(StoreError, match=message):
            found.transcript(none)
    with pytest.raises(
        StoreError, match=f"16 episodes whose keys begin with '': {', '.join(keys[:3])}, ...; give more"
    ):
        found.transcript("")
    twins = next(key[0] for key, other in itertools.pairwise(keys) if key[0] == other[0])
    with pytest.raises(StoreError, match=f"episodes whose keys begin with '{twins}': {twins}"):
        found.transcript(twins)


def test_a_notebook_shows_means(found):
    table = found._repr_html_()
    assert table.count("<tr>") == 1 + 2 * 2 * 2
    assert "<td>mistake(eps=1)</td>" in table


def read(path):
    if path.suffix == ".parquet":
        return parquet.read_table(path).to_pylist()
    if path.suffix == ".csv":
        with path.open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


@pytest.mark.parametrize("suffix", [".csv", ".jsonl", ".parquet"])
@pytest.mark.parametrize("table", ["episodes", "turns"])
def test_tables_are_read_back_as_they_were(found, tmp_path, monkeypatch, suffix, table):
    monkeypatch.setattr(results, "_CHUNK", 3)
    path = tmp_path / f"table{suffix}"
    arguments = ["study", "export", str(found.path), str(path)] + ["--turns"] * (table == "turns")
    result = CliRunner().invoke(app, arguments)
    rows = list(found.rows() if table == "episodes" else found.all_turns())
    assert result.stdout.startswith(f"{len(rows)} rows, stored in ")
    back = read(path)
    if suffix == ".jsonl":
        assert back == rows
        return
    for mine, other in zip(rows, back, strict=True):
        assert list(other) == list(mine)
        for name, value in mine.items():
            if suffix == ".parquet" and name not in ("action", "atoms"):
                assert other[name] == value
            elif value is None:
                assert other[name] in (None, "")
            elif isinstance(value, str) and suffix == ".csv":
                assert other[name] in (value, json.dumps(value))
            else:
                assert json.loads(other[name].replace("True", "true").replace("False", "false")) == value


SIGNS = ["=1+1", "+1", "-1", "@SUM(1)", "\tx", "\r=1", "\n=1", "=cmd|' /C calc'!A0", "\uff1d1", "\uff201"]
RUN = [*SIGNS, "'=1", "''", "'"]
HARMLESS = ["", "a=1", " =1", "north", "1", "a\n=1", '"=1"', "é", "long" * 40_000]


def test_no_cell_of_csv_is_run_by_a_spreadsheet_and_each_is_read_back(found, tmp_path):
    texts = [*RUN, *HARMLESS]
    rows = [{"key": text, "turn": 1, "reward": -0.5, "action": text, "thought": None} for text in texts]
    path = tmp_path / "turns.csv"
    results._write_csv(path, iter(rows), dict.fromkeys(rows[0]))
    limit = csv.field_size_limit(10**6)
    with path.open(newline="", encoding="utf-8") as file:
        written = [(row["key"], row["action"], row["reward"]) for row in csv.DictReader(file)]
    csv.field_size_limit(limit)
    assert [row["action"] for row in read_csv(path)] == [row["key"] for row in read_csv(path)] == texts
    assert [key for key, *_ in written] == [*(f"'{text}" for text in RUN), *HARMLESS]
    assert {reward for *_, reward in written} == {"-0.5"}, "a number stays one"
    names = [text for text in RUN if "\r" not in text]
    plot = Plot(name="p", title="", draw=None, columns=["student", "regret"], rows=[[text, -0.5] for text in names])
    assert [row[0] for row in csv.reader(io.StringIO(plot.csv, newline=""))][1:] == [f"'{text}" for text in names]


def test_what_cannot_be_given_is_refused(found, tmp_path, monkeypatch):
    with pytest.raises(StoreError, match=r"there is no file none\.db; give a store that `llf study run` made"):
        load("none.db")
    with pytest.raises(ValueError, match=r"must end in one of \.csv, \.jsonl, \.parquet, got 'x\.xls'"):
        found.export("x.xls")
    with pytest.raises(ValueError, match="table must be one of episodes, turns, got 'claims'"):
        found.export("x.csv", "claims")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'llf-teacher\[data\]'"):
        found.export(tmp_path / "x.parquet")
