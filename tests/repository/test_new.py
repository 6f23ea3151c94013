"""`llf new` writes a family, a personality, a student and a trait that pass their kits as they are."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from commands import llf

from llf_teacher.tools.scaffold import KINDS, write

ROOT = Path(__file__).parents[2]
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")
NAMES = dict(zip(KINDS, ("guess_it", "laconic", "trusting", "clumsy"), strict=True))


def clone(folder):
    """The folders of a clone, without the files."""
    for package in (*PACKAGES, "tests"):
        for each in (ROOT / package).rglob("*/"):
            (folder / each.relative_to(ROOT)).mkdir(parents=True, exist_ok=True)
    return folder


def test_what_is_begun_passes_its_tests_and_the_linter(tmp_path):
    for package in PACKAGES:
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    for folder in ("worlds", "teachers", "llf_teacher"):
        (tmp_path / "tests" / folder).mkdir(parents=True)
    written = [path for kind, name in NAMES.items() for path in write(kind, name, tmp_path)]
    tests = [str(path) for path in written if path.name.startswith("test_")]
    assert len(tests) == len(KINDS)

    def run(*command):
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        result = subprocess.run(
            [sys.executable, "-P", "-m", *command],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert result.returncode == 0, result.stdout + result.stderr
        return result.stdout

    assert "13 passed" in run("pytest", "-p", "no:cacheprovider", "--import-mode=importlib", *tests)
    assert "llf-guess-it-v0" in run("llf_teacher", "list")
    python = [str(path) for path in written if path.suffix == ".py"]
    run("ruff", "check", "--config", str(ROOT / "pyproject.toml"), *python)
    run("ruff", "format", "--check", "--config", str(ROOT / "pyproject.toml"), *python)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_overwritten(kind, tmp_path):
    clone(tmp_path)
    first, *others = write(kind, "maze", tmp_path)
    for each in others:
        each.unlink()
    first.write_text("mine")
    with pytest.raises(FileExistsError, match=f"{first.name} exists already, and nothing was written; choose another"):
        write(kind, "maze", tmp_path)
    assert first.read_text() == "mine"
    assert not any(each.exists() for each in others)


def test_a_package_of_the_name_counts(tmp_path):
    (clone(tmp_path) / "worlds" / "maze").mkdir()
    with pytest.raises(FileExistsError, match="maze exists already"):
        write("family", "maze", tmp_path)


@pytest.mark.parametrize("name", ["Maze", "a-maze", "class", "2d", "", "_", "mäze"])
def test_names_are_identifiers(name, tmp_path):
    with pytest.raises(
        ValueError, match=r"the name of a family must (be a lower-case Python identifier|have a letter)"
    ):
        write("family", name, clone(tmp_path))


def test_another_kind_is_refused(tmp_path):
    with pytest.raises(ValueError, match="unknown kind 'famly'; did you mean family"):
        write("famly", "maze", clone(tmp_path))


@pytest.mark.parametrize("kind", KINDS)
def test_the_command_says_what_to_do_next(kind, tmp_path):
    name = NAMES[kind]
    said = llf("new", kind, name, "--folder", str(clone(tmp_path)), cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    files = [line.removeprefix("wrote ") for line in said.stdout.splitlines() if line.startswith("wrote ")]
    assert files
    assert all(Path(file).is_file() for file in files)
    assert "    pytest -n0 tests/" in said.stdout
    assert f"test_{name}.py" in said.stdout


def test_it_is_run_in_a_clone(tmp_path):
    said = llf("new", "family", "maze", cwd=tmp_path)
    assert said.returncode == 2
    assert said.stderr.endswith("is not a folder; run it in a clone of the repository, or give --folder\n")
    assert not list(tmp_path.iterdir())
