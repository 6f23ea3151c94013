"""What is read becomes the only claim that says it, or none."""

import numpy as np
import pytest

from pz_envs.family import own_families
from pz_envs.text import claim_building
from pz_envs.text.claim_building import build_claim, make_reader
from pz_envs.text.phrases import SentenceReading, read_sentences
from teachers.atoms import Moment
from teachers.session import Session

FAMILIES = {family.name: family for family in own_families()}


def session_of(name):
    family = FAMILIES[name]
    world = family.make_world(**family.environments[family.showcase[0]])
    return family, Session(world, [family.make_teacher(world, instruction_type="b")], max_turns=20, instructs=True)


@pytest.mark.parametrize(("name", "least"), [("gridworld", 20), ("bandits", 20), ("poem", 12)])
def test_what_teachers_say_is_built_again(name, least):
    family, session = session_of(name)
    vocabulary, built = session.teacher_turns[0].vocabulary, 0
    reader = make_reader(family)
    for seed in range(3):
        session.open(seed)
        session.speak()
        for _ in range(3):
            if session.over:
                break
            plan = session.teacher.oracle.plan(session.world.truth, 1)
            session.act(plan[0] if plan else session.world.sample_action(np.random.default_rng(seed)))
            session.speak()
            for atom in session.atoms:
                readings = read_sentences(reader, atom.text)
                if type(atom.claim) not in vocabulary.classes.values() or len(readings) != 1:
                    continue
                claim = build_claim(readings[0], family, vocabulary, session.moment).claim
                if claim is not None and readings[0].claim is type(atom.claim):
                    assert claim.means(session.moment, session.teacher.oracle), atom.text
                    built += 1
    assert built >= least


@pytest.mark.parametrize(
    ("slots", "claim"),
    [
        ({"low": "3", "high": "6"}, {"low": 3, "high": 6}),
        ({"low": "3", "high": "six"}, None),  # no number
        ({"low": "3"}, None),  # the other is open
    ],
)
def test_all_fields_come_from_the_sentence(slots, claim):
    family = FAMILIES["bandits"]
    vocabulary = family.vocabulary()
    among = vocabulary.classes["Among"]
    found = build_claim(SentenceReading("", among, slots, None, False), family, vocabulary)
    assert (found.claim == among(**claim)) if claim else (found.claim is None and found.candidates)


def test_several_claims_are_candidates_and_too_many_are_not_tried(monkeypatch):
    family = FAMILIES["gridworld"]
    vocabulary = family.vocabulary()
    go = vocabulary.classes["Go"]
    several = build_claim(SentenceReading("", go, {}, None, False), family, vocabulary)
    assert several.claim is None
    assert len(several.candidates) == 3
    only = SentenceReading("", go, {"action": "North"}, None, False)
    assert build_claim(only, family, vocabulary).claim is not None
    monkeypatch.setattr(claim_building, "MOST_BUILT", 3)
    assert build_claim(only, family, vocabulary) == (None, ("Go",))


def test_a_plan_is_built_of_its_steps_and_a_rule_of_names_without_articles():
    for name, text, claim in [
        ("bandits", "Let me show you how to go on: 3, then 1.", {"type": "Example", "actions": [3, 1]}),
        (
            "poem",
            'Let me show you how to go on: "a b\nc. d", then "e".',
            {"type": "Example", "actions": ["a b\nc. d", "e"]},
        ),
        (
            "gridworld",
            "In every house of this town the treasure lies in a kitchen or an attic.",
            {"type": "TreasuresIn", "rooms": ["kitchen", "attic"]},
        ),
    ]:
        family = FAMILIES[name]
        vocabulary = family.vocabulary(family.make_world(**family.environments[family.showcase[0]]))
        (found,) = read_sentences(make_reader(family), text)
        assert build_claim(found, family, vocabulary).claim == vocabulary.claim_of(claim)


def test_a_verdict_takes_the_last_action_and_no_other():
    family, session = session_of("bandits")
    vocabulary = session.teacher_turns[0].vocabulary
    best = SentenceReading("", vocabulary.classes["PulledBest"], {}, None, False)
    opening = session.open(0)
    assert build_claim(best, family, vocabulary, opening).claim is None
    session.speak()
    assert build_claim(best, family, vocabulary, session.act(4)).claim == best.claim(action=4)
    assert isinstance(session.moment, Moment)


def test_a_reader_is_made_once_and_starts_anew():
    family = FAMILIES["bandits"]
    one, other = make_reader(family), make_reader(family)
    assert one._lines is other._lines
    assert one is not other
