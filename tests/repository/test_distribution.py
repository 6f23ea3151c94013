"""What is built from the source tree is whole, and what it asks of other packages is what is tested."""

import email
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import llf_teacher

ROOT = Path(__file__).parents[2]
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")
BESIDES = ("tests", "docs", "examples", "changes", ".ci")


def _files(folders):
    """The files in folders of the source tree, but for what running them leaves."""
    return {
        path.relative_to(ROOT).as_posix()
        for folder in folders
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def test_what_is_built_is_whole(tmp_path):
    """The wheel has every file of the packages and nothing else, the source distribution that it is built of all files.

    Of a copy, as building leaves files behind.
    """
    source, top = tmp_path / "source", {path.name for path in ROOT.iterdir() if path.is_file()}
    top = {name for name in top if not name.startswith((".coverage", ".git", "llf-study")) or name == ".gitignore"}
    for folder in (*PACKAGES, *BESIDES):
        shutil.copytree(ROOT / folder, source / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for name in top:
        shutil.copy(ROOT / name, source)
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path / "dist", source]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    (archive,) = (tmp_path / "dist").glob("*.tar.gz")
    files = _files(PACKAGES)
    assert {f"{package}/py.typed" for package in PACKAGES} < files
    packed = set(zipfile.ZipFile(wheel).namelist())
    assert {name for name in packed if ".dist-info/" not in name} == files
    assert all(any(name.endswith(f"licenses/{text}") for name in packed) for text in ("LICENSE", "NOTICE"))
    with tarfile.open(archive) as tar:
        entries = {entry.name.partition("/")[2] for entry in tar.getmembers() if entry.isfile()}
    _check_metadata(zipfile.ZipFile(wheel))
    assert wheel.stat().st_size < 2_000_000
    assert archive.stat().st_size < 6_000_000
    made = {"PKG-INFO", "setup.cfg"}
    assert {name for name in entries if ".egg-info/" not in name} - made == top | files | _files(BESIDES)


def _check_metadata(wheel):
    """The version, the command, and README, whose links an index can follow."""
    (info,) = {name.partition("/")[0] for name in wheel.namelist() if ".dist-info/" in name}
    metadata = email.message_from_bytes(wheel.read(f"{info}/METADATA"))
    assert (metadata["Name"], metadata["Version"]) == ("llf-teacher", llf_teacher.__version__)
    assert "llf = llf_teacher.cli:main" in wheel.read(f"{info}/entry_points.txt").decode()
    links = [*re.findall(r'\]\(([^)]+)\)|(?:src|srcset|href)="([^"]+)"', metadata.get_payload(decode=True).decode())]
    assert len(links) > 10
    assert all("".join(link).startswith(("https://", "#")) for link in links)
    assert not [name for name in wheel.namelist() if name.endswith((".db", ".pyc", ".log"))]


def test_the_project_has_addresses():
    metadata = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert {"Repository", "Documentation", "Changelog"} <= metadata["urls"].keys()
    documented = metadata["urls"]["Documentation"].removeprefix(metadata["urls"]["Repository"] + "/tree/main/")
    assert (ROOT / documented).is_dir()


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


def test_each_supported_python_has_a_turn():
    """`tests` and `lowest` play with the Python of the environment and the lowest; what is not at hand is entered."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    versions = [name.rpartition(" ")[2] for name in project["classifiers"] if "Python :: 3." in name]
    assert versions[0] == project["requires-python"].removeprefix(">=")
    run = (ROOT / ".ci" / "run").read_text()
    functions = "".join(
        f"{name}() {{{run.partition(f'{name}() {{')[2].partition('}')[0]}" + "}\n" for name in ("supported", "pythons")
    )
    stands_for = (
        "at_hand() { [[ $1 != 3.13 ]] && echo /usr/bin/python$1; }\n"
        "enter() { echo $1: $3; }\nstage() { echo $1 $2; }\npython() { echo 3.11; }\n"
    )
    command = [shutil.which("bash"), "-c", f"{functions}{stands_for}pythons"]
    assert subprocess.check_output(command, cwd=ROOT, text=True).splitlines() == [
        "python3.12 with_python /usr/bin/python3.12",
        "python3.13: not at hand",
    ]


def test_frameworks_take_turns():
    """`.ci/run` plays one of them: the number of commits says for which, so that none is left out."""
    run = (ROOT / ".ci" / "run").read_text()
    call = "frameworks tests/rl/[a-z]*/ tests/integrations/[a-z]*/"
    assert f"stage frameworks '{call}'" in run
    function = "frameworks() {" + run.partition("frameworks() {")[2].partition("\n}")[0] + "\n}"
    places = [path for each in ("rl", "integrations") for path in (ROOT / "tests" / each).iterdir()]
    folders = {path.name for path in places if path.is_dir() and path.name[0] != "_"}
    chosen = []
    for commits in range(100, 100 + len(folders)):
        stands_for_git = f"git() {{ echo {commits}; }}"
        told = function.replace(".ci/", "echo .ci/")
        command = [shutil.which("bash"), "-c", f"{stands_for_git}\n{told}\n{call}"]
        chosen.append(subprocess.check_output(command, cwd=ROOT, text=True).split())
    assert {name for _, name in chosen} == folders
    assert all((ROOT / script).is_file() for script, _ in chosen)
