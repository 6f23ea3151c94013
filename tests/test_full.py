"""Large sweeps: `pytest -m full`."""

import pytest

from llf_teacher.registry import entries
from llf_teacher.studies.episode import play
from llf_teacher.studies.study import EpisodeSpec
from teachers.testing import Pupil

pytestmark = pytest.mark.full


@pytest.mark.parametrize("entry", entries().values(), ids=lambda entry: entry.id)
@pytest.mark.parametrize("instruction_type", ["b", "p", "c"])
def test_every_claim_of_ten_thousand_turns_holds(entry, instruction_type):
    family = entry.family
    pupil = Pupil(
        lambda: family.make_world(**entry.options),
        family.make_teacher,
        max_turns=family.max_cycles,
        turns=100 if family.slow else 10_000,
    )
    false = [
        atom
        for atom, moment, lab in pupil.atoms(instruction_type=instruction_type)
        if not atom.claim.holds(moment, lab)
    ]
    assert not false


@pytest.mark.parametrize(
    "entry", [entry for entry in entries().values() if not entry.family.slow], ids=lambda entry: entry.id
)
@pytest.mark.parametrize("student", ["obedient", "text_only", "oracle"])
def test_students_who_know_succeed_on_a_thousand_seeds(entry, student):
    specs = [
        EpisodeSpec(entry.id, "oracle", student, "b", "a", entry.family.max_cycles, seed, "") for seed in range(1000)
    ]
    assert all(play(spec).episode.success for spec in specs)
