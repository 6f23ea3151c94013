"""The examples run, shortened."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_teaching_on_a_budget(tmp_path):
    command = [sys.executable, ROOT / "examples" / "teaching_on_a_budget.py", "--seeds", "2", "--episodes", "5"]
    result = subprocess.run(
        [*command, "--plot", tmp_path / "plot.png"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("| mistake correcting | ") == 2
    assert (tmp_path / "plot.png").stat().st_size > 10_000
