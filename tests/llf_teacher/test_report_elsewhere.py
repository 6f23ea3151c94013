"""What a report has, outside of its page: figures as files, transcripts in a terminal, a frame in a notebook."""

import csv
import re

import pytest
from studying import stored
from typer.testing import CliRunner

from llf_teacher.cli import app
from llf_teacher.studies import load
from llf_teacher.studies.definition.study import Study
from llf_teacher.studies.execution.episode import play
from llf_teacher.studies.execution.runner import manifest
from llf_teacher.studies.store import Store, StoreError

STUDY = Study(
    ids=("llf-bandits-BanditTenArmedRandomFixed-v0",),
    teachers=("oracle", "silent"),
    students=("obedient", "random"),
    seeds=3,
    max_turns=4,
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return stored(tmp_path_factory.mktemp("elsewhere") / "s.db", STUDY, manifest(STUDY))


def test_each_figure_stands_alone_with_its_data(path, tmp_path):
    result = CliRunner().invoke(app, ["study", "figures", f"{tmp_path / 'f'}", "--store", f"{path}"])
    assert result.exit_code == 0, result.output
    names = {"findings-scores", "findings-differences", "overall-profiles", "bandits-b-a-dots", "bandits-b-a-curves"}
    assert {file.name for file in (tmp_path / "f").iterdir()} == {
        f"{n}.{s}" for n in names for s in ("svg", "pdf", "csv")
    }
    for name in names:
        svg, pdf, table = (tmp_path / "f" / f"{name}.{suffix}" for suffix in ("svg", "pdf", "csv"))
        text = svg.read_text(encoding="utf-8")
        assert text.startswith("<?xml")
        assert "var(--" not in text
        assert re.search(r'width="[\d.]+pt"', text)
        assert pdf.read_bytes().startswith(b"%PDF")
        rows = list(csv.DictReader(table.read_text().splitlines()))
        assert {row["teacher"] for row in rows} >= {"oracle"}, name


def test_figures_are_the_same_each_time(path, tmp_path):
    first, second = (load(path).figures(tmp_path / name) for name in "ab")
    assert [file.read_bytes() for file in first] == [file.read_bytes() for file in second]


def test_a_transcript_in_the_terminal(path):
    key = next(STUDY.episodes()).key
    result = CliRunner().invoke(app, ["study", "transcript", f"{path}", key])
    assert result.exit_code == 0, result.output
    assert result.output.strip() == load(path).transcript(key).strip()


def test_a_notebook_shows_the_report(path, tmp_path):
    report = load(path).report()
    frame = report._repr_html_()
    assert frame.startswith("<iframe srcdoc=")
    assert frame.count("<") == 2
    report.save(tmp_path / "r.html")
    assert (tmp_path / "r.html").read_text(encoding="utf-8") == report.html


def test_a_store_without_a_study_says_so(tmp_path):
    with Store(tmp_path / "s.db") as store:
        store.add(play(next(STUDY.episodes())))
    with pytest.raises(StoreError, match=r"s\.db does not name its study; give the study, too"):
        load(tmp_path / "s.db").report()
    assert "Feedback study" in load(tmp_path / "s.db").report(STUDY).html
