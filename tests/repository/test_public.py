"""No public name goes or changes without a word in the changelog, and none is added unseen."""

import ast
from pathlib import Path

import pytest
from documents import python_blocks
from public_names import MODULES, changes_since, public_names, read_list, unexplained

import llf_teacher

ROOT = Path(__file__).parents[2]
LIST, CHANGELOG = ROOT / "tests" / "public.txt", ROOT / "CHANGELOG.md"
RELEASE, LISTED = read_list(LIST)
EXAMPLES = ("worlds.gridworld", "teachers.oracles.", "teachers.personalities.", "llf_teacher.students.traits.")
"""What documents also import: a family and personalities, as the examples that they are."""


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


def test_documents_import_what_is_public():
    packages = ("worlds", "teachers", "pz_envs", "llf_teacher")
    for block, code in python_blocks().items():
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in packages:
                assert node.module in MODULES or node.module.startswith(EXAMPLES), f"{block}: {node.module}"
                names = {f"name {node.module}.{alias.name}" for alias in node.names}
                assert node.module.startswith(EXAMPLES) or names <= LISTED, block
