"""No public name goes or changes without a word in the changelog, and none is added unseen."""

import ast
from pathlib import Path

import pytest
from commands import llf
from documents import python_blocks

import llf_teacher
from llf_teacher.cli.dev.public import MODULES, changes_since, public_names, read_list, unexplained

ROOT = Path(__file__).parents[2]
LIST, CHANGELOG = ROOT / "tests" / "public.txt", ROOT / "CHANGELOG.md"
RELEASE, LISTED = read_list(LIST)
EXAMPLES = ("worlds.gridworld", "teachers.oracles.", "teachers.personalities.", "llf_teacher.students.traits.")
"""What documents also import: a family and personalities, as the examples that they are."""


def test_public_names_are_those_of_the_list():
    """What is added is written into the list by `llf dev public tests/public.txt`."""
    names = [*public_names()]
    assert len(names) == len(set(names))
    assert not unexplained(LISTED - {*names}, changes_since(RELEASE, CHANGELOG))
    assert not {*names} - LISTED, "new names: run `llf dev public tests/public.txt`"


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


def test_the_command_keeps_what_is_lost_without_a_word(tmp_path):
    file, changelog = tmp_path / "public.txt", tmp_path / "CHANGELOG.md"
    head = f"# Public names of llf-teacher {RELEASE}, so far"
    file.write_text("\n".join([head, "name worlds.world.Lost", *sorted(LISTED)]), encoding="utf-8")
    changelog.write_text(f"# Changelog\n\n## {RELEASE}\n\n- `Lost` was added.\n")
    refused = llf("dev", "public", file, changelog)
    assert refused.returncode == 2
    assert "these are gone" in refused.stderr
    assert "name worlds.world.Lost; keep them" in refused.stderr
    (tmp_path / "changes").mkdir()
    (tmp_path / "changes" / "lost.removed.md").write_text("`Lost` is gone; use `World`.")
    written = llf("dev", "public", file, changelog)
    assert (written.returncode, written.stderr) == (0, "")
    assert "- name worlds.world.Lost\n" in written.stdout
    assert read_list(file) == (RELEASE, {*public_names()})
    file.write_text("name worlds.world.World\n")
    assert "must begin with" in llf("dev", "public", file, changelog).stderr


def test_documents_import_what_is_public():
    packages = ("worlds", "teachers", "pz_envs", "llf_teacher")
    for block, code in python_blocks().items():
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and node.module.partition(".")[0] in packages:
                assert node.module in MODULES or node.module.startswith(EXAMPLES), f"{block}: {node.module}"
                names = {f"name {node.module}.{alias.name}" for alias in node.names}
                assert node.module.startswith(EXAMPLES) or names <= LISTED, block
