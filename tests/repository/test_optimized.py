"""The command line under `python -OO`, which removes docstrings and assertions."""

import subprocess
import sys

PROGRAM = """
from typer.main import get_command
from typer.testing import CliRunner

from llf_teacher.cli import app

def walk(command, path):
    shown = CliRunner().invoke(app, [*path, "--help"], env={"COLUMNS": "200"})
    print(" ".join(["llf", *path]), shown.exit_code, "|".join(line.strip() for line in shown.stdout.splitlines()))
    for name, each in getattr(command, "commands", {}).items():
        walk(each, [*path, name])

walk(get_command(app), [])
"""


def test_every_command_has_help_without_docstrings() -> None:
    result = subprocess.run([sys.executable, "-OO", "-c", PROGRAM], capture_output=True, text=True, check=False)
    assert not result.returncode, result.stderr
    helps = [line for line in result.stdout.splitlines() if line.startswith("llf ")]
    assert len(helps) > 20
    for line in helps:
        command, usage, rest = line.partition("Usage: ")
        assert " 0 " in command, line
        texts = [text for text in rest.split("|")[1:] if text]
        assert usage, line
        assert texts[0][0].isalpha(), f"{command} begins with no sentence: {texts[0]}"
    assert not any("No help" in line for line in helps)
    (check,) = (line for line in helps if line.startswith("llf study check "))
    assert "Check that a store is complete and unchanged." in check
