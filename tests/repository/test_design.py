"""The default tests are sampled by a design: no value is left out, each version draws anew, `full` is the whole."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import design
import pytest
from design import amount, cover, shown_by_families
from shelf import FAMILIES, light, pairs

from llf_teacher.registry import entries
from teachers.personality import PERSONALITIES

TESTS = Path(__file__).parents[1]
PAIRS = [{name, spec} for name, spec in pairs()]
CHEAP = [0] * len(PAIRS)
SIZES = """
import json, pytest, sys

class Sizes:
    def pytest_collection_finish(self, session):
        sizes = {item.nodeid: [mark.name for mark in item.iter_markers()] for item in session.items}
        with open(sys.argv[1], "w") as file:
            json.dump(sizes, file)

sys.exit(pytest.main(["--collect-only", "-n", "0", "-m", "", *sys.argv[2:]], plugins=[Sizes()]))
"""


def test_a_cover_shows_every_family_and_every_personality():
    chosen = cover(PAIRS, CHEAP, "any")
    shown = set().union(*(PAIRS[place] for place in chosen))
    assert shown == {name for name in FAMILIES if not FAMILIES[name].slow} | set(map(light, PERSONALITIES.names))
    assert len(chosen) <= len(shown)


def test_it_is_drawn_anew_for_each_version():
    first, again, other = (cover(PAIRS, CHEAP, version) for version in ("0.1.0", "0.1.0", "0.2.0"))
    assert first == again != other


def test_it_grows_with_the_sum_and_not_the_product():
    many = [{("family", i), ("personality", j)} for i in range(50) for j in range(200)]
    assert 200 <= len(cover(many, [0] * len(many), "any")) <= 250


def test_of_what_is_dear_it_has_what_nothing_cheaper_shows():
    rows = [(family, number) for family in "abcd" for number in range(9)]
    costs = [2 if family == "d" or number == 8 else int(family == "c") for family, number in rows]
    chosen = [rows[place] for place in cover(rows, costs, "any")]
    assert {number for _, number in chosen} == set(range(9))
    assert 1 <= sum(family == "d" or number == 8 for family, number in chosen) <= 2
    assert 1 <= sum(family == "c" for family, _ in chosen) <= 2


def test_amounts_are_whole_in_the_full_size_only(monkeypatch):
    for size, expected in (("quick", 4), ("", 4), ("smoke", 4), ("full", 40)):
        monkeypatch.setattr(design, "_size", "")
        design.set_size(size)
        assert amount(4, full=40) == expected


@pytest.mark.parametrize("value", [lambda id, entry: id, lambda id, entry: entry], ids=["id", "entry"])
def test_a_sweep_of_environments_shows_each_family_with_all_else(value):
    rows = [(value(id, entry), other) for id, entry in entries().items() for other in "ab"]
    cases = [SimpleNamespace(callspec=SimpleNamespace(params={"it": it, "other": other})) for it, other in rows]
    chosen = cover(shown_by_families(cases), [0] * len(cases), "any")
    assert len(chosen) == 2 * len(FAMILIES) < len(cases)
    table = [SimpleNamespace(callspec=SimpleNamespace(params={"id": id})) for id in list(entries())[:3]]
    assert shown_by_families([*table, SimpleNamespace()]) is None  # of one family, and a case without parameters


def test_sizes_are_within_each_other_and_full_is_the_whole(tmp_path):
    where = [TESTS / "conformance" / "test_shelf.py", TESTS / "teachers" / "test_parking_oracle.py"]
    command = [sys.executable, "-c", SIZES, tmp_path / "sizes", *where]
    result = subprocess.run(command, cwd=TESTS.parent, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    marks = json.loads((tmp_path / "sizes").read_text())
    smoke, quick, full = ({case for case in marks if size in marks[case]} for size in ("smoke", "quick", "full"))
    assert smoke < quick < full == marks.keys()
    tests, by_default = ({case.partition("[")[0] for case in cases} for cases in (full, quick))
    assert tests > by_default  # some are marked by hand
    for test in (test for test in tests if "test_shelf.py" in test):
        shown = {name for case in quick for name in FAMILIES if case.startswith(f"{test}[{name}-")}
        assert shown == {name for case in full for name in FAMILIES if case.startswith(f"{test}[{name}-")}
