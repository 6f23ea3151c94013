"""With numba the same is planned as without it; machine code is kept for as long as the sources are the same."""

import json
import math
import os
import pty
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from design import amount

from teachers import compiled
from teachers.oracles.parking import paths
from teachers.oracles.parking.driving import solve
from teachers.oracles.parking.model import Ground, can_stop, misfit, misses, move, pairs

SLOTS = np.arange(-28, 29, 4.0)


def cases(count):
    """Cars somewhere in a car park, every other one with parked cars."""
    rng = np.random.default_rng(5)
    for number in range(count):
        x, y = rng.choice(SLOTS), rng.choice((-14.0, 14.0))
        rows = [(each, row) for each in SLOTS for row in (-14.0, 14.0) if (each, row) != (x, y)]
        parked = [place for place in rows if rng.random() < 0.4] if number % 2 else []
        car = rng.uniform((-28, -9, -4, -6), (28, 9, 4, 6)).tolist()
        yield (float(x), float(y), math.copysign(math.pi / 2, y)), parked, tuple(car)


def outcomes(count, planned):
    """What is planned, and what the model says of it; else what it says of a way straight on."""
    found = []
    for spot, parked, car in cases(count):
        ground = Ground(spot, 1.44, pairs(parked), 34.5, 20.5)
        way = solve(ground, car) if planned else [(0.5, 0.25)] * 4
        there = [move(ground, car, pedal, wheel) for pedal in (-100, 0, 37) for wheel in (-100, 5, 100)]
        stops = [can_stop(each, car) for each in (ground, ground._replace(caution=-1))]
        found.append(
            [way, there, stops, misses(ground, car, way), misses(ground, car, way[:-1]), misfit(ground, *car[:3])]
        )
    return json.dumps([compiled.COMPILED, found])


def test_the_same_is_planned_to_the_last_bit():
    """In a process that compiles; this one does not."""
    asked = amount((8, False), full=(50, True))  # to compile the planner takes half a minute
    program = f"from test_compiled import outcomes; print(outcomes{asked})"
    folders = Path(__file__).parent, Path(__file__).parents[1] / "helpers"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "0", "PYTHONPATH": os.pathsep.join(map(str, folders))}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", program], check=True, capture_output=True, text=True, env=environment
    )
    (fast, there), (slow, here) = json.loads(run.stdout), json.loads(outcomes(*asked))
    assert fast
    assert not slow
    assert here == there


def test_paths_are_sorted_alike_with_and_without_machine_code():
    rng = np.random.default_rng(1)
    rows = [paths.Path(float(rng.integers(9)), int(number), 0, 0, (0.0,) * 6) for number in rng.permutation(60)]
    assert paths._sorted(rows.copy()) == sorted(rows)
    assert paths._sorted([]) == []


@pytest.fixture
def compiling(monkeypatch):
    """What compiles, whatever the environment says."""
    monkeypatch.setattr(compiled, "COMPILED", True)
    monkeypatch.setattr(compiled, "numba", numba, raising=False)
    return numba


def test_code_is_kept_for_the_sources_of_now(tmp_path):
    """Those of other folders, too, whose functions are called."""
    own, other = tmp_path / "own", tmp_path / "other"
    for folder in (own, other):
        folder.mkdir()
        (folder / "one.py").write_text("1")
    kept = compiled._cache_folder.__wrapped__
    before = kept((own, other), "")
    assert before == kept((own, other), "")
    assert before.parent == own / "__pycache__"
    assert kept((own, other), "elsewhere").parent == Path("elsewhere")
    for folder in (own, other):
        (folder / "one.py").write_text("2")
        assert kept((own, other), "") != before
        before = kept((own, other), "")


def test_folders_are_those_of_called_functions():
    """Of the world's, too, in which the car's step is defined."""
    program = (
        "from teachers.oracles.parking import driving, model, reeds_shepp\n"
        "for each in (model.misfit, driving._follow, reeds_shepp.wrapped):\n"
        "    print(*[folder.name for folder in each.folders])"
    )
    environment = os.environ | {"NUMBA_DISABLE_JIT": "0"}
    run = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True, env=environment)
    assert run.stdout.splitlines() == ["parking worlds", "parking worlds", "parking"]


PROGRAM = """
import sys

import numba

from teachers.compiled import compiled

assert numba.njit(lambda x: x)(1) == 1  # of no concern

@compiled
def half(x):
    return x / 2

@compiled
def quarter(x):
    return half(half(x))

for each in sys.argv[1:]:
    assert quarter(float(each) if "." in each else int(each)) == 1
"""


def test_it_says_what_it_compiles_and_not_what_it_loads(tmp_path):
    """Elsewhere in one line, on a terminal in one that moves."""
    (tmp_path / "program.py").write_text(PROGRAM)
    environment = os.environ | {"NUMBA_DISABLE_JIT": "0", "TERM": "xterm", "COLUMNS": "200"}
    said = []
    for (ours, theirs), numbers in ((os.pipe(), ["4.0"]), (pty.openpty(), ["4.0", "4"])):
        program = [sys.executable, tmp_path / "program.py", *numbers]
        subprocess.run(program, check=True, stderr=theirs, env=environment)
        said.append(os.read(ours, 65_536).decode())
        os.close(ours)
        os.close(theirs)
    what = "Compiling __main__ with numba; later processes load it"
    assert said[0] == f"{what}\n"
    assert f"{what} (function 2, half)" in said[1]
    assert "(function 3" not in said[1]


@pytest.mark.parametrize("may_be_written", [True, False])
def test_what_cannot_be_kept_is_compiled_all_the_same(tmp_path, monkeypatch, compiling, may_be_written):
    """Numba's own setting is as it was."""
    folder = tmp_path / "kept"
    if not may_be_written:
        folder.write_text("a file")
    calls = []
    monkeypatch.setattr(
        compiling, "njit", lambda *given, **options: calls.append(options) or (lambda function: function)
    )
    monkeypatch.setattr(compiling.config, "CACHE_DIR", str(folder))
    compiled.compiled(lambda: None)
    assert calls == [{"cache": True} if may_be_written else {}]
    assert str(folder) == compiling.config.CACHE_DIR
