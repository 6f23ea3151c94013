"""Hedged claims reach students, records, reports and films, and count neither as true nor as false."""

import itertools

import pytest
from hedging import hedging
from shelf import FAMILIES

from llf_teacher.episodes.loop import play_turns
from llf_teacher.episodes.record import as_dict
from llf_teacher.gym import StudentEnv
from llf_teacher.students.parsing import parse_student
from llf_teacher.studies import Study, run
from pz_envs.text.phrases import Reader
from teachers.atoms import Atom, HedgedClaim, Label, unhedged
from teachers.common import Late, Probably, hedge
from teachers.oracles.gridworld.claims import Go
from teachers.personality import PERSONALITIES, parse_personality
from teachers.phrasebook import Drawn
from teachers.testing import Pupil
from teachers.voice import voice_names
from teachers.words import VERDICTS
from worlds.gridworld import Direction

GRID = "llf-gridworld-v0"
WEST = hedge(Go(action=Direction.WEST), 0.8)


def pupil(name="gridworld", turns=30):
    family = FAMILIES[name]
    return Pupil(family.make_world, family.make_teacher, max_turns=6, turns=turns)


@pytest.mark.parametrize("spec", [name for name in PERSONALITIES.names if FAMILIES["gridworld"].serves(name)])
def test_every_personality_takes_hedges(spec):
    """Honest ones say nothing flat that is false, and of hedges nothing that shows which of them are true."""
    after = PERSONALITIES[spec]()
    lab, said = pupil().make_world().scratch(), []
    for episode in pupil().taught(hedging() | after, 30):
        for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
            said.append(atom)
            if after.honest and not isinstance(atom.claim, HedgedClaim):
                assert atom.claim.holds(episode[atom.about_turn].moment, lab), atom
    assert said or after.mute or spec in ("oracle", "silent")


@pytest.mark.parametrize("spec", ["vague(q=1)", "hinter"])
def test_what_is_hedged_is_not_made_vague_by_the_truth(spec):
    for episode in pupil().taught(hedging() | parse_personality(spec), 30):
        assert all(isinstance(atom.claim, HedgedClaim) for heard in episode for atom in heard.atoms)


def test_a_mistake_about_a_hedge_is_one_about_what_it_hedges():
    lab, found = pupil().make_world().scratch(), 0
    for episode in pupil().taught(hedging() | parse_personality("mistake(eps=1)"), 30):
        for atom in itertools.chain.from_iterable(heard.atoms for heard in episode):
            assert isinstance(atom.claim, HedgedClaim)
            assert not atom.claim.claim.holds(episode[atom.about_turn].moment, lab)
            found += 1
    assert found > 10


@pytest.mark.parametrize("voice", voice_names())
def test_readers_read_what_is_hedged_and_when(voice, rng):
    book = FAMILIES["gridworld"].phrasebook(voice)
    reader = Reader(FAMILIES["gridworld"].phrasebook, voice_names())
    for draw in rng.random(20).tolist():
        words = book.say([WEST, Late(claim=WEST, turn=2)], 5, Drawn([draw, draw]), "random")
        now, late = reader.read(words)
        assert (now.claim, now.slots, now.about_turn) == (Go, {"action": "west"}, None), words
        assert (late.claim, late.slots, late.about_turn) == (Go, {"action": "west"}, 2), words


@pytest.mark.parametrize("student", ["obedient", "text_only"])
def test_students_that_believe_what_they_hear_follow_hedged_advice(student):
    env = StudentEnv(GRID, teacher=hedging(low=0.51, high=0.99), feedback_type="fp", max_turns=8)
    policy = parse_student(student).seat(env.family, env.session.world)
    advised, followed = 0, 0
    for seed in range(5):
        hinted = None
        for turn in play_turns(env, policy, seed):
            if hinted is not None:
                advised, followed = advised + 1, followed + (turn.moment.action == hinted)
            hints = [unhedged(atom.claim).action for atom in turn.atoms if isinstance(unhedged(atom.claim), Go)]
            hinted = hints[0] if len(hints) == 1 else None
    assert followed == advised > 10


@pytest.mark.parametrize("student", ["bayesian", "tamer", "reasoner(worlds=8)", "random"])
def test_other_students_take_hedges(student):
    options = {"map": True} if student.startswith("reasoner") else {}
    env = StudentEnv(GRID, teacher=hedging(), max_turns=6, **options)
    policy = parse_student(student).seat(env.family, env.session.world)
    assert any(isinstance(atom.claim, Probably) for turn in play_turns(env, policy, 0) for atom in turn.atoms)


def test_a_record_keeps_the_hedge_what_it_hedges_and_whether_that_holds():
    said = as_dict(Atom(WEST, "words", 3), Label.HEDGED, False, "gridworld")
    assert said == {
        "kind": "fp",
        "claim": "common.Probably",
        "fields": {"claim": {"claim": "gridworld.Go", "fields": {"action": 2}}, "p": 0.8},
        "action": 2,
        "text": "words",
        "about_turn": 3,
        "holds": False,
        "label": "hedged",
    }


def test_a_study_counts_hedges_apart(tmp_path):
    study = Study(ids=[GRID], teachers=["hedging:hedging", "oracle"], students=["random"], seeds=3, max_turns=5)
    results = run(study, tmp_path / "s.db", workers=1)
    for row in results.rows():
        flat = row["truthful"] + row["late"] + row["placebo"] + row["distorted"]
        atoms = [a for turn in results.turns(row["key"]) for a in turn["atoms"] if a["kind"] is not None]
        hedges = [a for a in atoms if a["label"] == "hedged"]
        assert row["claims"] == len(atoms) == flat + len(hedges)
        assert row["claims_held"] == sum(a["holds"] for a in atoms if a["label"] != "hedged") == flat
        if row["teacher"] != "oracle":
            assert not flat
            assert 0 < sum(a["holds"] for a in hedges) < len(hedges)
            text = results.transcript(row["key"])
            assert text.count("~: ") == len(hedges)
            assert "!: " not in text
    page = results.report().html
    assert "hedged" in page
    assert "Probably(claim=Go(action=" in page


def test_films_and_pages_say_that_a_hedge_is_one():
    env = StudentEnv(GRID, teacher=hedging(), privileged_info=True, render_mode="rgb_array")
    env.reset(seed=0)
    env.step(1)
    renderer = env.student_view.renderer
    assert {str(VERDICTS[each.verdict]) for each in renderer.sentences if each.kind is not None} == {"~ hedged"}
    assert env.render().shape == (480, 640, 3)
