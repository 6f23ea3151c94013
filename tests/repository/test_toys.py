"""The kits accept the toys of an outsider: files beside those of the packages, and nothing else."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
TOYS = Path(__file__).parents[1] / "toys"
KITS = """
from functools import partial
from llf_teacher.registry import family
from pz_envs.testing import check_family, check_seats
from teachers.testing import Pupil, check_oracle, check_personality
from worlds.testing import check_world
door = family("door")
pupil = Pupil(door.make_world, door.make_teacher, max_turns=door.max_turns)
check_family(door)
check_world(door.make_world)
check_oracle(pupil)
check_seats(partial(door.env))
check_personality("terse", pupil)
print("accepted")
"""


def test_the_kits_accept_a_small_family_and_a_small_personality(tmp_path):
    for package in ("worlds", "teachers", "pz_envs", "llf_teacher"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(TOYS, tmp_path, dirs_exist_ok=True)
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    result = subprocess.run(
        [sys.executable, "-c", KITS], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.endswith("accepted\n")
