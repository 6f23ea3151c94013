"""A family in a distribution of its own is found, listed, made, studied and audited like any other."""

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import llf_teacher
from pz_envs.family import PLUGINS, all_families

ROOT = Path(__file__).parents[2]
SOURCE = Path(__file__).parents[1] / "plugin_package"
STUDY = """
ids = ["llf-thermostat-v0", "llf-thermostat-Far-v0"]
teachers = ["oracle", "mistake(eps=1)", "silent"]
students = ["obedient", "text_only", "oracle", "reward_only"]
instruction_types = ["p"]
seeds = 1
"""


def put_in_place(folder, entry_points, source=SOURCE):
    """Put a package in place as an installer would, with metadata that name other entry points."""
    project = tomllib.loads((source / "pyproject.toml").read_text())["project"]
    for package in (path for path in source.iterdir() if path.is_dir() and (path / "__init__.py").exists()):
        shutil.copytree(package, folder / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    dist_info = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    dist_info.mkdir(parents=True)
    (dist_info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = [f"[{PLUGINS}]", *(f"{name} = {value}" for name, value in entry_points.items())]
    (dist_info / "entry_points.txt").write_text("\n".join(lines))


def run(folder, *arguments, cwd=None):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])}
    command = [sys.executable, *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, env=environment)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder into which pip has installed the package, from a copy, since building leaves files behind."""
    source = shutil.copytree(SOURCE, tmp_path_factory.mktemp("source") / "package")
    folder = tmp_path_factory.mktemp("site")
    offline = ("--no-deps", "--no-index", "--no-build-isolation", "--disable-pip-version-check")
    command = [sys.executable, "-m", "pip", "install", *offline, "--target", str(folder), str(source)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return folder


def test_it_is_not_seen_where_it_is_not_installed():
    assert "thermostat" not in [family.name for family in all_families()]
    assert not [id for id in llf_teacher.ids() if "thermostat" in id]


def test_it_is_listed(installed, tmp_path):
    result = run(installed, "-m", "llf_teacher", "list", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "thermostat: bring a room to the wanted temperature" in result.stdout
    assert "  llf-thermostat-Far-v0\n" in result.stdout
    assert not result.stderr


MAKE = """
import sys, gymnasium, pettingzoo, llf_teacher
from pz_envs.family import all_families
assert not [name for name in sys.modules if name in ("llf_thermostat.world", "llf_thermostat.oracle")], "too early"
(family,) = [family for family in all_families() if family.name == "thermostat"]
assert (family.distribution, family.module) == ("llf-thermostat", "llf_thermostat.family")
for make in (llf_teacher.make, gymnasium.make):
    for id in ("llf-thermostat-v0", "verbal-thermostat-Far-v0"):
        observation, info = make(id).reset(seed=0)
        assert observation["instruction"] and info["success"] is False
for kind in ("aec", "parallel"):
    pettingzoo.make(kind, "llf/thermostat-v0", speech="kinds").reset(seed=0)
assert llf_teacher.supported_types("llf-thermostat-v0") == (("b", "p", "c"), ("r", "hp", "hn", "fp", "fn"))
assert len(llf_teacher.ids()) == int(sys.argv[1]) + 2
"""


def test_it_is_made(installed):
    result = run(installed, "-W", "error", "-c", MAKE, str(len(llf_teacher.ids())))
    assert result.returncode == 0, result.stderr


KITS = """
import sys
from functools import partial
from pz_envs.family import all_families
from pz_envs.testing import check_seats
from teachers.testing import Pupil, check_oracle
from worlds.testing import check_world
(family,) = [family for family in all_families() if family.name == "thermostat"]
for options in family.environments.values():
    make_world = partial(family.make_world, **options)
    check_world(make_world)
    check_oracle(Pupil(make_world, family.make_teacher, max_turns=family.max_turns, turns=300))
check_seats(partial(family.env, least=5, most=9))
"""


def test_it_passes_the_kits(installed):
    result = run(installed, "-c", KITS)
    assert result.returncode == 0, result.stderr


AUDIT = """
import sys
from pathlib import Path
from llf_teacher.studies.store import Store
with Store(Path(sys.argv[1])) as store:
    for row in store.episodes():
        held = row["claims_held"], row["claims"]
        print(row["teacher"], row["student"], row["family"], row["version"], row["success"], *held)
"""


def test_it_is_studied_with_a_report_and_all_claims_hold(installed, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    files = ("--store", "a.db", "--report", "a.html", "--workers", "2")
    result = run(installed, "-m", "llf_teacher", "study", "run", "study.toml", *files, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "Played 24 episodes" in result.stderr
    report = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "thermostat" in report
    assert "extra turns of the knob" in report
    rows = [line.split() for line in run(installed, "-c", AUDIT, "a.db", cwd=tmp_path).stdout.splitlines()]
    assert len(rows) == 24
    for teacher, student, family, version, success, held, claims in rows:
        assert family == "thermostat"
        assert version == f"{llf_teacher.__version__}+llf-thermostat-1.2"
        said = int(claims)
        if teacher == "oracle":
            assert said > 4
            assert (student == "reward_only") or success == "1"
        # The parts of an instruction are said by every teacher, and true.
        assert int(held) == said if teacher != "mistake(eps=1)" else int(held) <= 1 < said


def test_golden_transcripts(installed, tmp_path):
    for folder in ("one", "two"):
        result = run(installed, "-m", "llf_teacher", "dev", "golden", folder, "llf-thermostat-v0", cwd=tmp_path)
        assert result.returncode == 0, result.stderr
    text = (tmp_path / "one" / "llf-thermostat-v0.txt").read_text(encoding="utf-8")
    assert "Recipe" in text
    assert "FALSE" not in text
    assert text == (tmp_path / "two" / "llf-thermostat-v0.txt").read_text(encoding="utf-8")


BROKEN = {
    "bad_module": ("llf_none.family:FAMILY", "ModuleNotFoundError(\"No module named 'llf_none'\")"),
    "bad_name": ("llf_thermostat.family:NONE", "AttributeError"),
    "bad_type": ("llf_thermostat.family:env", "must be a pz_envs.family.Family, got"),
    "bad_syntax": ("llf_broken.syntax:FAMILY", "SyntaxError"),
    "bad_id": ("llf_broken.unversioned:FAMILY", "environments must be named as in 'name-v0', got 'broken'"),
    "bad_twin": ("llf_broken.twin:FAMILY", "taken by the family"),
    "bad_empty": ("llf_broken.empty:FAMILY", "declares no environments"),
    "bad_showcase": ("llf_broken.showcase:FAMILY", "showcase and sampled must name its environments, got 'other-v0'"),
    "bad_env": ("llf_broken.envless:FAMILY", "has no attribute 'env'"),
}
DECLARATION = """
from dataclasses import replace
from llf_thermostat.family import FAMILY, env, raw_env, parallel_env
FAMILY = replace(FAMILY, {})
"""


def test_a_broken_plugin_is_left_out_with_a_warning(tmp_path):
    site = tmp_path / "site"
    put_in_place(site, {name: value for name, (value, _) in BROKEN.items()} | {"a_good": GOOD})
    broken = site / "llf_broken"
    broken.mkdir()
    (broken / "__init__.py").touch()
    (broken / "syntax.py").write_text("FAMILY = ")
    mine = "name='broken', environments={'broken-v0': {}}, showcase=('broken-v0',)"
    for name, changes in {
        "unversioned": "name='broken', environments={'broken': {}}",
        "twin": "summary='again'",
        "empty": "name='broken', environments={}",
        "showcase": "name='broken', environments={'broken-v0': {}}, showcase=('other-v0',)",
        "envless": mine,
    }.items():
        (broken / f"{name}.py").write_text(DECLARATION.format(changes))
    with (broken / "envless.py").open("a") as file:
        file.write("\ndel env")
    result = run(site, "-c", "import llf_teacher; print(*llf_teacher.ids())", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "llf-thermostat-v0" in result.stdout
    assert "broken" not in result.stdout
    for name, (value, cause) in BROKEN.items():
        (line,) = [line for line in result.stderr.splitlines() if f"the family {name!r} of llf-thermostat" in line]
        assert f"({value}) is left out" in line
        assert cause in line


GOOD = "llf_thermostat.family:FAMILY"


def test_a_missing_dependency_names_the_plugins_pip_line(installed):
    program = (
        "import sys, llf_teacher; sys.modules['llf_thermostat.world'] = None; llf_teacher.make('llf-thermostat-v0')"
    )
    result = run(installed, "-c", program)
    assert "run: pip install 'llf-thermostat'" in result.stderr
