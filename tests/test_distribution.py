"""What is built from the source tree has all of it that is needed: the modules, the data and the marks of types."""

import shutil
import subprocess
import sys
import tarfile
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
