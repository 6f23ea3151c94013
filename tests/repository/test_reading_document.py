"""The document on the store has every column, and the study file of the one on reports is one."""

import re
from pathlib import Path

from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec
from llf_teacher.studies.definition.study import load_study

DOCS = Path(__file__).parents[2] / "docs"
STORES = (DOCS / "internals" / "stores.md").read_text(encoding="utf-8")
REPORT = (DOCS / "reading-a-study.md").read_text(encoding="utf-8")


def test_every_column_is_described_once():
    table, _, _ = STORES[STORES.index("| column | meaning |") :].partition("\n\n")
    named = [name for row in re.findall(r"^\| (`.*?) \| ", table, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]
    assert named == ["key", *EpisodeSpec._fields, *EpisodeRow._fields, "revision"]


def test_the_columns_of_the_report_are_columns():
    table, _, _ = REPORT[REPORT.index("| column | means |") :].partition("\n\n")
    named = re.findall(r"`(\w+)`", table)
    assert len(named) > 20
    assert not set(named) - {*EpisodeSpec._fields, *EpisodeRow._fields}


def test_its_study_file_is_one(tmp_path):
    (tmp_path / "study.toml").write_text(re.search(r"```toml\n(.*?)```", REPORT, re.DOTALL)[1])
    study = load_study(tmp_path / "study.toml")
    assert study.transcripts[0]["seeds"] == (0, 3)
