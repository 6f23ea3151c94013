"""Large sweeps: `pytest -m full`."""

import itertools

import pytest

import llf_teacher
from llf_teacher.episodes.loop import play_turns
from llf_teacher.episodes.record import EpisodeSpec
from llf_teacher.episodes.recorder import Recorder
from llf_teacher.registry import entries
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies.execution.episode import play
from llf_teacher.tools.audit import audit
from teachers.atoms import Label
from teachers.personality import PERSONALITIES
from teachers.testing import Pupil

pytestmark = pytest.mark.full

every_environment = pytest.mark.parametrize("entry", entries().values(), ids=lambda entry: entry.id)


def share(entry):
    """Turns in an environment that make up at least 1,000 for its family, and at least 100."""
    return max(100, -(-1000 // len(entry.family.environments)))


@every_environment
@pytest.mark.parametrize("instruction_type", ["b", "p", "c"])
def test_every_claim_of_ten_thousand_turns_holds(entry, instruction_type):
    family = entry.family
    pupil = Pupil(
        lambda: family.make_world(**entry.options),
        family.make_teacher,
        max_turns=family.max_turns,
        turns=100 if family.slow else 10_000,
    )
    false = [
        atom
        for atom, moment, lab in pupil.atoms(instruction_type=instruction_type)
        if not atom.claim.holds(moment, lab)
    ]
    assert not false


@every_environment
def test_no_honest_personality_is_caught(entry):
    for spec in PERSONALITIES.names:
        if PERSONALITIES[spec]().honest and entry.family.serves(spec):
            found = audit(entry.id, spec, turns=share(entry))
            assert not found.caught, (spec, found.examples)
            assert found.count(Label.DISTORTED) == 0
            assert found.turns == share(entry)


@every_environment
@pytest.mark.parametrize("spec", ["mistake(eps=1)", "adversarial", "sycophant"])
def test_every_distorted_atom_is_found(entry, spec):
    """What the oracle did not offer is labelled as false, whoever is told."""
    distorted = turns = 0
    for student in map(parse_student, itertools.cycle(("random", "obedient"))):
        if turns >= share(entry):
            break
        env = llf_teacher.make(entry.id, teacher=spec, text=student.text)
        recorder = Recorder(env.family.name, env.student_view)
        for turn in play_turns(env, student.seat(env.family, env.session.world), turns):
            turns += turn.moment.turn > 0
            for atom, label in recorder.check(turn):
                if atom.kind is not None and atom.claim not in env.teacher.offered:
                    distorted += 1
                    assert label is Label.DISTORTED
        env.close()
    assert distorted


@pytest.mark.parametrize(
    "entry", [entry for entry in entries().values() if not entry.family.slow], ids=lambda entry: entry.id
)
@pytest.mark.parametrize("student", ["obedient", "text_only", "oracle"])
def test_students_who_know_succeed_on_a_thousand_seeds(entry, student):
    specs = [
        EpisodeSpec(entry.id, "oracle", student, "b", "a", entry.family.max_turns, seed, "") for seed in range(1000)
    ]
    assert all(play(spec).episode.success for spec in specs)
