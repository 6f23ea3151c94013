"""The words of other moments are true there, and as many, of the same kinds and as long as the oracle's."""

import copy
import pickle
from collections import Counter
from functools import cache

import numpy as np
import pytest
from lessons import pupil
from shelf import FAMILIES, QUICK

from teachers.atoms import FP, HedgedClaim, Label
from teachers.common import Late
from teachers.elsewhere import Elsewhere
from teachers.session import Session
from worlds.testing import plain

TURNS = 40
CLUED = [name for name in QUICK if FAMILIES[name].serves("ruler")]


def session_of(name, spec="misaligned", **settings):
    world = pupil(name).make_world()
    teacher = pupil(name).make_teacher(world, spec, **settings)
    return Session(world, [teacher], max_turns=FAMILIES[name].max_turns, instructs=True)


@cache
def episodes(name):
    return pupil(name).episodes(TURNS)


def heard(name, spec="misaligned", **settings):
    """Per turn: the moment, the atoms of feedback, and the moment elsewhere of each."""
    session = session_of(name, spec, **settings)
    for seed, moments in enumerate(episodes(name)):
        session.open(seed)
        for moment in moments:
            session.follow(moment)
            session.speak()
            atoms = [atom for atom in session.atoms if atom.kind is not None]
            yield moment, atoms, [session.origin(atom) for atom in atoms]


def kinds(atoms):
    return Counter(atom.kind for atom in atoms)


@pytest.mark.parametrize("name", QUICK)
def test_each_claim_is_true_of_another_moment(name):
    lab = pupil(name).make_world().scratch()
    false = 0
    for moment, atoms, origins in heard(name):
        for atom, there in zip(atoms, origins, strict=True):
            assert atom.claim.holds(there, lab), (atom, there)
            false += not atom.claim.holds(moment, lab)
    assert false > TURNS / 2


@pytest.mark.parametrize("name", QUICK)
def test_it_says_as_many_claims_of_each_kind_as_the_oracle_and_is_as_long(name):
    said = {spec: [atoms for _, atoms, _ in heard(name, spec)] for spec in ("misaligned", "oracle")}
    assert list(map(kinds, said["misaligned"])) == list(map(kinds, said["oracle"]))
    words = {spec: np.mean([len(atom.text.split()) for atoms in each for atom in atoms]) for spec, each in said.items()}
    assert words["misaligned"] == pytest.approx(words["oracle"], rel=0.1)


@pytest.mark.parametrize("name", QUICK)
def test_advice_is_mostly_not_that_of_the_moment(name):
    lab = pupil(name).make_world().scratch()
    holds = [atom.claim.holds(moment, lab) for moment, atoms, _ in heard(name, feedback_type="fp") for atom in atoms]
    assert len(holds) > TURNS / 2
    assert np.mean(holds) < 0.5


@pytest.mark.parametrize("name", QUICK)
def test_the_taught_world_does_not_change(name):
    session = session_of(name)
    session.open(3)
    before = plain(session.world.save())
    session.speak()
    assert plain(session.world.save()) == before


def traces(name, spec):
    session = session_of(name, spec)
    rng = np.random.default_rng(5)
    session.open(4)
    session.speak()
    for _ in range(5):
        if session.over:
            break
        session.act(session.world.sample_action(rng))
        session.speak()
        yield plain(session.state), session.moment.reward


@pytest.mark.parametrize("name", QUICK)
def test_the_worlds_trace_is_that_of_any_teacher(name):
    assert [*traces(name, "misaligned")] == [*traces(name, "silent")]


@pytest.mark.parametrize("name", QUICK)
def test_words_elsewhere_depend_on_the_seed_alone(name):
    first, again = ([str(atoms) for _, atoms, _ in heard(name)] for _ in range(2))
    assert first == again


def test_what_is_elsewhere_does_not_depend_on_what_the_student_does():
    """The moments to choose from are the same for students that do other things."""
    found = []
    for action in (0, 1):
        session = session_of("bandits", feedback_type="fp")
        session.open(1)
        session.speak()
        while not session.over:
            session.act(action)
            session.speak()
        (stage,) = session.teacher._stage._stages
        found.append([(said.moment, said.claims) for said in stage._elsewhere.moments])
    assert found[0] == found[1]


def test_copies_and_pickles_know_where_a_claim_is_from():
    session = session_of("gridworld")
    session.open(1)
    session.speak()
    session.act(0)
    session.speak()
    lab = session.world.scratch()
    for twin in (copy.deepcopy(session), pickle.loads(pickle.dumps(session))):
        for atom in session.atoms:
            assert twin.origin(atom) == session.origin(atom)
            assert atom.claim.holds(twin.origin(atom), lab)
        twin.act(1)
        twin.speak()
    session.act(1)
    session.speak()
    assert twin.atoms == session.atoms


@pytest.mark.parametrize("spec", ["delayed(turns=1) | misaligned", "misaligned | delayed(turns=1)"])
def test_late_claims_are_of_the_moment_elsewhere(spec):
    lab = pupil("gridworld").make_world().scratch()
    found = [
        (moment.turn - atom.about_turn, atom.claim.holds(there, lab))
        for moment, atoms, origins in heard("gridworld", spec)
        for atom, there in zip(atoms, origins, strict=True)
    ]
    assert set(found) == {(1, True)}


def test_kinds_and_voices_compose():
    for moment, atoms, _ in heard("gridworld", "only(kinds='fp') | misaligned"):
        assert set(kinds(atoms)) <= {FP}
        assert moment.success or atoms
    world = pupil("gridworld").make_world()
    texts = []
    for voice in ("plain", "warm"):
        teacher = FAMILIES["gridworld"].make_teacher(world, personality="misaligned", voice=voice)
        session = Session(world, [teacher], max_turns=20, instructs=True)
        session.open(2)
        session.speak()
        texts.append(([atom.claim for atom in session.atoms], str(session.feedback)))
    assert texts[0][0] == texts[1][0]
    assert texts[0][1] != texts[1][1]


@pytest.mark.parametrize("name", CLUED)
def test_clues_are_replaced_by_clues(name):
    given = {type(atom.claim) for _, atoms, _ in heard(name, "ruler") for atom in atoms}
    lab = pupil(name).make_world().scratch()
    said = [
        pair for _, atoms, origins in heard(name, "ruler | misaligned") for pair in zip(atoms, origins, strict=True)
    ]
    assert all(atom.claim.holds(there, lab) for atom, there in said)
    assert (
        np.mean([type(atom.claim) in given for atom, _ in said]) > 0.8
    )  # some are of classes that were not given here


def test_a_hedged_claim_stays_hedged():
    world = FAMILIES["gridworld"].make_world(map=True)
    teacher = FAMILIES["gridworld"].make_teacher(
        world, personality="partial(worlds=64) | misaligned", feedback_type="fp"
    )
    session = Session(world, [teacher], max_turns=20, instructs=True)
    hedged = 0
    for seed in range(12):
        session.open(seed)
        session.speak()
        for atom in session.atoms:
            if isinstance(atom.claim, HedgedClaim):
                hedged += 1
                assert atom.claim.claim.holds(session.origin(atom), world.scratch())
                assert atom.label([session.moment], world.scratch()) is Label.HEDGED
    assert hedged


def test_stages_behind_it_leave_its_claims_as_they_are():
    """Its claims are true elsewhere: nothing follows from them here."""
    for spec in ("vague", "hinter"):
        plain_, after = (
            [atoms for _, atoms, _ in heard("bandits", each)] for each in ("misaligned", f"misaligned | {spec}")
        )
        kept = [atom.claim for atoms in after for atom in atoms]
        assert set(kept) <= {atom.claim for atoms in plain_ for atom in atoms}


def test_the_instruction_is_that_of_the_lesson():
    said = [session_of("gridworld", spec, instruction_type="c") for spec in ("misaligned", "oracle")]
    for session in said:
        session.open(3)
    assert said[0].instruction == said[1].instruction


def test_other_lessons_go_on_and_keep_few_moments():
    name = "gridworld"
    teacher = pupil(name).make_teacher(pupil(name).make_world())
    elsewhere = Elsewhere(teacher.oracle, set(teacher.kinds), lambda claim: 1.0, np.random.default_rng(0))
    for _ in range(60):
        elsewhere.go_on()
    assert len(elsewhere.moments) <= 10
    assert {said.moment.turn for said in elsewhere.moments} != {0}
    assert not any(isinstance(claim, Late) for said in elsewhere.moments for claim in said.claims)


@pytest.mark.parametrize(
    "id", ["poem-Haiku-v0", "poem-Tanka-v0", "optimization-Booth-v0", "gridworld-v0", "reco-movie-v0"]
)
def test_a_world_elsewhere_has_another_task(id):
    name = next(name for name in FAMILIES if id in FAMILIES[name].environments)
    world = FAMILIES[name].make_world(**FAMILIES[name].environments[id])
    lab = world.scratch()
    world.reset(seed=1)
    here = world.truth
    found = [lab.elsewhere(seed) for seed in (1, 2, 2)]
    assert found[1] == found[2] != found[0]
    world.restore(found[0])
    assert world.truth == found[0]
    if name == "poem":
        assert len(found[0].pattern) == len(here.pattern)
        assert not any(a == b for a, b in zip(found[0].pattern, here.pattern, strict=True))
    if name == "optimization":
        assert found[0].shift != here.shift == (0.0, 0.0)
