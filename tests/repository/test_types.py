"""The packages and the documents' code keep to their types."""

import subprocess
import sys

import pytest
from documents import ROOT, python_blocks

PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")


@pytest.mark.full  # half a minute; `.ci/run habits` plays it
def test_mypy_is_content(tmp_path):
    """As strict as `pyproject.toml` has it; each block of a document is a program of its own.

    What mypy finds out it keeps where it does by itself, for the next run, whoever begins that.
    """
    for name, code in python_blocks().items():
        (tmp_path / f"{name.replace('-', '_')}.py").write_text(code, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", *PACKAGES, *tmp_path.glob("*.py")]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
