"""Golden transcripts: `llf dev golden tests/golden` writes them, this replays them."""

import math
import re
from pathlib import Path

import pytest

from llf_teacher.registry import entries
from llf_teacher.tools.golden import transcript

FOLDER = Path(__file__).parent / "golden"
_NUMBER = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")


def same(line, golden):
    """Whether lines are equal but for the last digits of floats."""
    if _NUMBER.split(line) != _NUMBER.split(golden):
        return False
    pairs = zip(_NUMBER.findall(line), _NUMBER.findall(golden), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=1e-6, abs_tol=1e-9) for a, b in pairs)


SAMPLED = [id for id, entry in entries().items() if entry.sampled]


@pytest.mark.parametrize("id", SAMPLED)
def test_replay(id):
    golden = (FOLDER / f"{id}.txt").read_text(encoding="utf-8").splitlines()
    lines = transcript(id).splitlines()
    assert len(lines) == len(golden)
    different = [f"{line}\n  golden: {old}" for line, old in zip(lines, golden, strict=True) if not same(line, old)]
    assert not different, "\n".join(different)


def test_no_missing_and_no_extra_file():
    assert {path.stem for path in FOLDER.glob("*.txt")} == set(SAMPLED)


@pytest.mark.parametrize("id", SAMPLED)
def test_every_claim_in_a_transcript_holds(id):
    assert "FALSE" not in (FOLDER / f"{id}.txt").read_text(encoding="utf-8")
