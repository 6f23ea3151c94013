"""No public name goes or changes without a word in the changelog, and none is added unseen."""

import ast
import re
from pathlib import Path
from string import Template

import pytest
from documents import DOCUMENTS, python_blocks
from public_names import MODULES, NAMES, changes_since, public_names, read_list, unexplained

import llf_teacher

ROOT = Path(__file__).parents[2]
LIST, CHANGELOG = ROOT / "tests" / "public.txt", ROOT / "CHANGELOG.md"
RELEASE, LISTED = read_list(LIST)
PACKAGES = ("worlds", "teachers", "pz_envs", "llf_teacher")
EXAMPLES = (
    "worlds.gridworld",
    "worlds.maze",
    "teachers.oracles.",
    "teachers.personalities.",
    "llf_teacher.students.traits.",
)
"""What documents also import: a family and personalities, as the examples that they are; the templates' own world."""


def test_public_names_are_those_of_the_list():
    """The list is edited by hand; the message has the lines."""
    names = [*public_names()]
    assert len(names) == len(set(names))
    lost = unexplained(LISTED - {*names}, changes_since(RELEASE, CHANGELOG))
    assert not lost, "these are gone; keep them, or say in a file of `changes` what replaces them:\n" + "\n".join(lost)
    new = sorted({*names} - LISTED)
    assert not new, "these are new; add them to tests/public.txt:\n" + "\n".join(new)


def test_the_list_is_that_of_the_last_release():
    assert ".dev" in llf_teacher.__version__ or llf_teacher.__version__ == RELEASE
    assert f"\n## {RELEASE}\n" in CHANGELOG.read_text(encoding="utf-8")


def test_the_list_has_names_of_every_sort():
    for name in (
        "name llf_teacher.make",
        "name teachers.atoms.Claim",
        "command llf study run --workers",
        "id llf-gridworld-v0",
        "id llf-metaworld-reach-v2",
        "option gridworld num_rooms",
        "teacher mistake eps",
        "teacher llm_teacher model",
        "student q_learning trust",
        "voice curt",
        "seating panel",
        "setting feedback_type",
        "study seeds",
    ):
        assert name in LISTED


@pytest.mark.parametrize(
    ("lost", "changes", "found"),
    [
        ("name worlds.world.World", "`World` is called `Simulator`.", True),
        ("name worlds.world.World", "Worlds are called simulators.", False),
        ("name worlds.world.World", "`worlds.world` is `worlds.simulator`.", True),
        ("name llf_teacher.make", "`llf_teacher.studies.run` is quicker.", False),
        ("command llf study run --workers", "`--workers` is `--processes`.", True),
        ("command llf study run --workers", "There are more workers.", False),
        ("id llf-maze-v0", "`llf-maze-v1` has doors.", False),
        ("teacher mistake eps", "`mistake(rate=0.1)` in place of `eps`.", True),
        ("rules gridworld = 2", "The gridworld is larger.", False),
        ("rules gridworld = 2", "The rules of the gridworld are version 3.", True),
    ],
)
def test_what_is_lost_has_to_be_named(lost, changes, found):
    assert unexplained([lost], changes) == ([] if found else [lost])


def documents():
    """The code that users read or start from, by name: blocks of documents, the quickstart, templates of `llf new`."""
    yield from python_blocks().items()
    for path in (ROOT / "docs" / "quickstart").glob("*.py"):
        yield path.name, path.read_text(encoding="utf-8")
    for path in (ROOT / "llf_teacher" / "tools" / "scaffold").rglob("*.py.txt"):
        code = Template(path.read_text(encoding="utf-8"))
        yield f"{path.relative_to(ROOT)}", code.safe_substitute(name="maze", Name="Maze")


def imports():
    """What documents import from this distribution's packages: the document, a module, and a name or None."""
    for document, code in documents():
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in PACKAGES:
                yield from ((document, node.module, alias.name) for alias in node.names)
            elif isinstance(node, ast.Import):
                found = (alias.name for alias in node.names)
                yield from ((document, name, None) for name in found if name.partition(".")[0] in PACKAGES)


def test_documents_import_what_is_public():
    found = [each for each in imports() if not each[1].startswith(EXAMPLES)]
    assert {"llf_teacher", "llf_teacher.studies", "teachers.atoms", "worlds.testing"} <= {each[1] for each in found}
    for document, module, name in found:
        public = module in (*MODULES, *PACKAGES) if name is None else f"name {module}.{name}" in LISTED
        assert public, (
            f"{document} imports {module}, {name}: list it in tests/helpers/public_names.py, or show another way"
        )


def test_single_names_are_in_documents():
    """One that no document imports or mentions is private again."""
    texts = " ".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
    shown = {f"{module}.{name}" for _, module, name in imports()}
    shown |= set(re.findall(r"(?:worlds|teachers|pz_envs|llf_teacher)(?:\.\w+)+", texts.replace(":", ".")))
    assert [name for name in NAMES if name not in shown] == []
    doors = [name for name in NAMES if name.rpartition(".")[0] in MODULES]
    assert not doors, f"all names of these modules are public: {doors}"
