"""What is built from the source tree is whole, and what it asks of other packages is what is tested."""

import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")


def test_the_wheel_has_every_file_of_the_packages_and_nothing_else(tmp_path):
    """It is built from the source distribution, which needs them, too; of a copy, as building leaves files behind."""
    left_out = shutil.ignore_patterns("__pycache__", ".*", "*.egg-info", "build", "dist", "tests")
    source = shutil.copytree(ROOT, tmp_path / "source", ignore=left_out)
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path / "dist", source]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    (archive,) = (tmp_path / "dist").glob("*.tar.gz")
    files = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {f"{package}/py.typed" for package in PACKAGES} < files
    packed = set(zipfile.ZipFile(wheel).namelist())
    assert {name for name in packed if ".dist-info/" not in name} == files
    assert all(any(name.endswith(f"licenses/{text}") for name in packed) for text in ("LICENSE", "NOTICE"))
    with tarfile.open(archive) as tar:
        assert files < {name.partition("/")[2] for name in tar.getnames()}


def test_the_lowest_versions_that_are_declared_are_those_that_are_tried():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    declared = {*project["dependencies"], *extras["llm"], *extras["test"]}
    lines = (ROOT / "constraints-lowest.txt").read_text().splitlines()
    tried = [line for line in lines if not line.startswith("#")]
    assert tried == sorted(requirement.replace(">=", "==") for requirement in declared)
    assert all(requirement.count("==") == 1 for requirement in tried)
    (python,) = re.findall(r">=([\d.]+)", project["requires-python"])
    stage = (ROOT / ".ci" / "run").read_text().partition("lowest() {")[2].partition("\n}")[0]
    assert f"python{python} -m venv" in stage
    assert "-c constraints-lowest.txt" in stage
