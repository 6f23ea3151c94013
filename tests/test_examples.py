"""The examples run, shortened."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def test_teaching_on_a_budget(tmp_path):
    command = [sys.executable, ROOT / "examples" / "teaching_on_a_budget.py", "--seeds", "2", "--episodes", "5"]
    result = subprocess.run(
        [*command, "--plot", tmp_path / "plot.png"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("| mistake correcting | ") == 2
    assert (tmp_path / "plot.png").stat().st_size > 10_000


@pytest.mark.full
def test_learn_to_teach(tmp_path):
    """Needs the extra `learn`."""
    command = [sys.executable, ROOT / "examples" / "learn_to_teach.py", "--steps", "2000", "--seeds", "3"]
    result = subprocess.run(
        [*command, "--episodes", "2", "--save", tmp_path / "teacher", "--plot", tmp_path / "plot.png"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert "| learned | " in result.stdout
    assert "| announced mistake | " in result.stdout
    assert {file.name for file in (tmp_path / "teacher").iterdir()} == {"teacher.zip", "scales.pkl"}
    assert (tmp_path / "plot.png").stat().st_size > 10_000
