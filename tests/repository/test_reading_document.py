"""The document on reading a study has every column, and its study file is one."""

import re
from pathlib import Path

from llf_teacher.episodes.record import EpisodeRow, EpisodeSpec
from llf_teacher.studies.definition.study import load_study

TEXT = (Path(__file__).parents[2] / "docs" / "reading-a-study.md").read_text(encoding="utf-8")


def test_every_column_is_described_once():
    table, _, _ = TEXT[TEXT.index("| column | meaning |") :].partition("\n\n")
    named = [name for row in re.findall(r"^\| (`.*?) \| ", table, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)]
    assert named == ["key", *EpisodeSpec._fields, *EpisodeRow._fields, "revision"]


def test_its_study_file_is_one(tmp_path):
    (tmp_path / "study.toml").write_text(re.search(r"```toml\n(.*?)```", TEXT, re.DOTALL)[1])
    study = load_study(tmp_path / "study.toml")
    assert study.transcripts[0]["seeds"] == (0, 3)
